// Reinsertion of many subtrees at once (Meister, Bittner 2018, "Parallel Reinsertion for Bounding Volume Hierarchy
// Optimization"): the search, the locks, the moves. A move takes X from its parent P and puts it beside Y:
//
//        P                       S's slot becomes that of Y, Y's slot that of the new parent, whose pair is still that
//       / \        Y             of X; P's slot becomes that of S. These three slots are what a move writes, and locks.
//      X   S
//
// Every kernel: launched as any number of groups, which share the candidates; does nothing where there is nothing left.
//   inout  found, state [candidates] (reinsert_state.clh)
// find_places
//   in     nodes, parents
// lock_gains, lock_ties
//   inout  locks [2 * nodes]: the largest gain that wants a slot, and the largest slot among the subtrees with that
//   gain
// find_winners
//   out    moving [nodes]: of subtrees whose moves have all their locks, the candidate's number and 1
// check_targets: of two moves one of which carries the other's target away, the lesser one loses. So no two, nor any
//   number of them, can put each other's subtrees into each other
//   out    locks: zeros
// make_moves
//   inout  nodes, parents, moving; the new parent's box is still Y's
//   out    changes [groups]
// undo_moves: does nothing unless the pass is undone; leaves boxes to be refitted
#include "work_group.clh"
#include "aabb.clh"
#include "node.clh"
#include "tree_nodes.clh"
#include "node_area.clh"
#include "reinsert_state.clh"
#include "reinsert_search.clh"

KERNEL void find_places(global const float* nodes, global const uint* parents, global const uint* control,
                        global Found* found, global uint* state) {
    if (control[IS_DONE]) return;
    const uint count = control[CANDIDATES];
    FOR_CANDIDATES(i, count) {
        found[i] = find_place(nodes, parents, found[i].from);
        state[i] = 0;
    }
}

// The slots that a move locks, in .s012.
static inline uint4 slots_of(Found move, global const uint* parents) {
    return (uint4)(parents[move.from / 2], SIBLING_OF(move.from), move.to, 0);
}

KERNEL void lock_gains(global const uint* parents, global const uint* control, global const Found* found,
                       global uint* locks) {
    if (control[IS_DONE]) return;
    const uint count = control[CANDIDATES];
    FOR_CANDIDATES(i, count) {
        const Found move = found[i];
        if (move.gain == 0) continue;
        const uint4 slots = slots_of(move, parents);
        atomic_max(locks + 2 * (size_t)slots.x, move.gain);
        atomic_max(locks + 2 * (size_t)slots.y, move.gain);
        atomic_max(locks + 2 * (size_t)slots.z, move.gain);
    }
}

static inline void lock_tie(global uint* lock, Found move) {
    if (lock[0] == move.gain) atomic_max(lock + 1, move.from);
}

KERNEL void lock_ties(global const uint* parents, global const uint* control, global const Found* found,
                      global uint* locks) {
    if (control[IS_DONE]) return;
    const uint count = control[CANDIDATES];
    FOR_CANDIDATES(i, count) {
        const Found move = found[i];
        if (move.gain == 0) continue;
        const uint4 slots = slots_of(move, parents);
        lock_tie(locks + 2 * (size_t)slots.x, move);
        lock_tie(locks + 2 * (size_t)slots.y, move);
        lock_tie(locks + 2 * (size_t)slots.z, move);
    }
}

static inline int has_lock(global const uint* lock, Found move) {
    return lock[0] == move.gain && lock[1] == move.from;
}

KERNEL void find_winners(global const uint* parents, global const uint* control, global const Found* found,
                         global const uint* locks, global uint* state, global uint* moving) {
    if (control[IS_DONE]) return;
    const uint count = control[CANDIDATES];
    FOR_CANDIDATES(i, count) {
        const Found move = found[i];
        if (move.gain == 0) continue;
        const uint4 slots = slots_of(move, parents);
        if (has_lock(locks + 2 * (size_t)slots.x, move) && has_lock(locks + 2 * (size_t)slots.y, move) &&
            has_lock(locks + 2 * (size_t)slots.z, move)) {
            state[i] = HAS_WON;
            moving[move.from] = (uint)i + 1;
        }
    }
}

static inline void release_lock(global uint* lock) {
    atomic_xchg(lock, 0u);
    atomic_xchg(lock + 1, 0u);
}

KERNEL void check_targets(global const uint* parents, global const uint* control, global const Found* found,
                          global const uint* moving, global uint* locks, global uint* state) {
    if (control[IS_DONE]) return;
    const uint count = control[CANDIDATES];
    FOR_CANDIDATES(i, count) {
        const Found move = found[i];
        if (move.gain == 0) continue;
        const uint4 slots = slots_of(move, parents);
        release_lock(locks + 2 * (size_t)slots.x);
        release_lock(locks + 2 * (size_t)slots.y);
        release_lock(locks + 2 * (size_t)slots.z);
        if (moving[move.from] != i + 1) continue;
        for (uint slot = move.to; slot != move.pivot; slot = parents[slot / 2]) {
            if (moving[slot] == 0) continue;
            const uint other = moving[slot] - 1;
            const uint other_gain = found[other].gain;
            const int is_lesser = move.gain < other_gain || (move.gain == other_gain && move.from < slot);
            atomic_or(state + (is_lesser ? (uint)i : other), HAS_LOST);
        }
    }
}

// Tells the children of what stands in `slot` now that it does.
static inline void adopt(float8 node, uint slot, global uint* parents) {
    if (is_inner_node(node)) parents[FIRST_OF(node) / 2] = slot;
}

static inline void write_node(float8 node, uint slot, global float* nodes, global uint* parents) {
    vstore8(node, slot, nodes);
    adopt(node, slot, parents);
}

static inline float8 inner_node(float8 box, uint first) {
    return (float8)(box.s012, as_float(first), box.s456, as_float(0u));
}

KERNEL void make_moves(global float* nodes, global uint* parents, global const uint* control, global Found* found,
                       global const uint* state, global uint* moving, global Change* changes) {
    local Change scratch[WORK_GROUP_SIZE];
    Change change = {0, 0};
    const uint count = control[IS_DONE] ? 0 : control[CANDIDATES];
    const float scale = as_float(control[SCALE]);
    FOR_CANDIDATES(i, count) {
        if (state[i] == 0) continue;
        const Found move = found[i];
        moving[move.from] = 0;
        if (state[i] != HAS_WON) continue;
        const uint sibling = SIBLING_OF(move.from);
        const uint parent = parents[move.from / 2];
        const float8 old_parent = vload8(parent, nodes);
        const float8 stays = vload8(sibling, nodes);
        const float8 target = vload8(move.to, nodes);
        write_node(stays, parent, nodes, parents);
        write_node(target, sibling, nodes, parents);
        write_node(inner_node(target, move.from & ~1u), move.to, nodes, parents);
        found[i].pivot = parent;
        change = replace_area(change, in_units(half_area_of(old_parent), scale), in_units(half_area_of(target), scale));
    }
    change = sum_changes(scratch, change);
    if (LOCAL_ID == 0) changes[get_group_id(0)] = change;
}

KERNEL void undo_moves(global float* nodes, global uint* parents, global const uint* control, global const Found* found,
                       global const uint* state) {
    if (!control[IS_UNDONE]) return;
    const uint count = control[CANDIDATES];
    FOR_CANDIDATES(i, count) {
        if (state[i] != HAS_WON) continue;
        const Found move = found[i];
        const uint parent = move.pivot;
        const float8 target = vload8(SIBLING_OF(move.from), nodes);
        const float8 stays = vload8(parent, nodes);
        write_node(target, move.to, nodes, parents);
        write_node(stays, SIBLING_OF(move.from), nodes, parents);
        write_node(inner_node(stays, move.from & ~1u), parent, nodes, parents);
    }
}
