// Reinsertion: the boxes above the moves, and what the moves came to.
//
// mark_changes: counts, for each sibling pair that changed or has a changed pair below it, what it has to wait for
//   in     parents; found, state (reinsert_state.clh)
//   inout  arrivals [pairs]: from zeros
//   launch any number of groups, which share the candidates
// refit_changes: each pair's parent gets its box when the pair itself is done
//   inout  arrivals: back to zeros; nodes; ranks [nodes], histogram [RANKS]: as rate_nodes would leave them
//   out    changes [groups]
//   launch as mark_changes; one group, where groups hand nothing over within a launch
// Both where is_undoing only if the pass is undone, else unless there is nothing left to do.
// end_pass: whether the moves are worth it, and what the next pass does
//   in     move_changes [groups], box_changes [box_groups]
//   inout  control, area [1]
//   launch one group
#include "work_group.clh"
#include "aabb.clh"
#include "node.clh"
#include "tree_nodes.clh"
#include "node_area.clh"
#include "between_groups.clh"
#include "reinsert_state.clh"

// Most of the nodes that a pass tries to move, as ReinsertConfig::candidates; ends when a pass with so many lowers the
// sum of areas by less than LEAST_GAIN of it. Whenever one saves less than GOOD_GAIN the next tries twice as many.
#define MOST_PART (1.0f / MOST_PART_DIVISOR)
#ifndef LEAST_GAIN
#define LEAST_GAIN 0.001f
#endif
#ifndef GOOD_GAIN
#define GOOD_GAIN 0.02f
#endif

static inline int is_wanted(global const uint* control, uint is_undoing) {
    return is_undoing ? control[IS_UNDONE] : !control[IS_DONE];
}

// The pairs that a move changes beside those above them: that of the subtree, and that of the former parent's slot, or
// where it is undone that of the target's.
static inline uint2 changed_pairs(Found move, uint is_undoing) {
    return (uint2)(move.from / 2, (is_undoing ? move.to : move.pivot) / 2);
}

// Pair 0 has no parent.
static inline void mark_upwards(uint pair, global const uint* parents, global uint* arrivals) {
    while (pair != 0 && atomic_inc(arrivals + pair) == 0)
        pair = parents[pair] / 2;
}

KERNEL void mark_changes(global const uint* parents, global const uint* control, uint is_undoing,
                         global const Found* found, global const uint* state, global uint* arrivals) {
    if (!is_wanted(control, is_undoing)) return;
    const uint count = control[CANDIDATES];
    FOR_CANDIDATES(i, count) {
        if (state[i] != HAS_WON) continue;
        const uint2 pairs = changed_pairs(found[i], is_undoing);
        mark_upwards(pairs.x, parents, arrivals);
        mark_upwards(pairs.y, parents, arrivals);
    }
}

typedef struct {
    global float* nodes;
    global const uint* parents;
    global uint* arrivals;
    global ushort* ranks;
    global uint* histogram;
    float scale;
} Refit;

// Boxes pass from group to group within the launch (between_groups.clh). Where memory is coherent whole vectors do,
// between the fences around the counter, and are several times as fast as words.
#if MEMORY_IS_COHERENT
static inline float8 load_shared(global float* nodes, size_t slot) {
    return vload8(slot, nodes);
}
static inline void store_shared(float8 node, global float* nodes, size_t slot) {
    vstore8(node, slot, nodes);
}
#else
static inline float8 load_shared(global float* nodes, size_t slot) {
    global uint* const node = (global uint*)nodes + 8 * slot;
    const Box box = observe_box(node);
    return (float8)(box.lower_x, box.lower_y, box.lower_z, as_float(node[3]), box.upper_x, box.upper_y, box.upper_z,
                    as_float(node[7]));
}
static inline void store_shared(float8 node, global float* nodes, size_t slot) {
    const Box box = {node.s0, node.s1, node.s2, node.s4, node.s5, node.s6};
    publish_box((global uint*)nodes + 8 * slot, box);
}
#endif

static inline void set_rank(Refit refit, size_t slot, ushort rank) {
    const ushort before = refit.ranks[slot];
    if (rank == before) return;
    refit.ranks[slot] = rank;
    if (before > 0) atomic_dec(refit.histogram + before);
    if (rank > 0) atomic_inc(refit.histogram + rank);
}

static inline Change refit_upwards(Refit refit, uint pair, Change change) {
    while (pair != 0) {
        // Whoever comes last finds all below in place.
        DEVICE_FENCE();
        if (atomic_dec(refit.arrivals + pair) != 1) break;
        DEVICE_FENCE();
        const uint slot = refit.parents[pair];
        const float8 left = load_shared(refit.nodes, 2 * (size_t)pair);
        const float8 right = load_shared(refit.nodes, 2 * (size_t)pair + 1);
        const float8 before = load_shared(refit.nodes, slot);
        const float8 lower = MIN_OF(left, right);
        const float8 upper = MAX_OF(left, right);
        const float8 fitted = (float8)(lower.s012, before.s3, upper.s456, before.s7);
        const float area = half_area_of(fitted);
        change = replace_area(change, in_units(half_area_of(before), refit.scale), in_units(area, refit.scale));
        set_rank(refit, 2 * (size_t)pair, slot == ROOT_SLOT ? 0 : rank_of(area - half_area_of(left)));
        set_rank(refit, 2 * (size_t)pair + 1, slot == ROOT_SLOT ? 0 : rank_of(area - half_area_of(right)));
        store_shared(fitted, refit.nodes, slot);
        pair = slot / 2;
    }
    return change;
}

KERNEL void refit_changes(global float* nodes, global const uint* parents, global const uint* control, uint is_undoing,
                          global const Found* found, global const uint* state, global uint* arrivals,
                          global ushort* ranks, global uint* histogram, global Change* changes) {
    local Change scratch[WORK_GROUP_SIZE];
    const Refit refit = {nodes, parents, arrivals, ranks, histogram, as_float(control[SCALE])};
    const uint count = is_wanted(control, is_undoing) ? control[CANDIDATES] : 0;
    Change change = {0, 0};
    FOR_CANDIDATES(i, count) {
        if (state[i] != HAS_WON) continue;
        const uint2 pairs = changed_pairs(found[i], is_undoing);
        change = refit_upwards(refit, pairs.x, change);
        change = refit_upwards(refit, pairs.y, change);
    }
    change = sum_changes(scratch, change);
    if (LOCAL_ID == 0) changes[get_group_id(0)] = change;
}

KERNEL void end_pass(global const Change* move_changes, uint groups, global const Change* box_changes, uint box_groups,
                     global uint* control, global long* area) {
    local Change scratch[WORK_GROUP_SIZE];
    Change change = {0, 0};
    FOR_WORK_ITEMS(i, 0, groups) {
        change = add_changes(change, move_changes[i]);
    }
    FOR_WORK_ITEMS(i, 0, box_groups) {
        change = add_changes(change, box_changes[i]);
    }
    change = sum_changes(scratch, change);
    if (LOCAL_ID > 0 || control[IS_DONE]) return;
    // Moves of one pass can spoil each other's gains where they share ancestors.
    const int is_better = change.rise + change.doubt < 0;
    const float gain = is_better ? (float)-change.rise : 0.0f;
    const float sum = (float)*area;
    const float part = as_float(control[PART]);
    if (is_better) *area += change.rise;
    control[IS_UNDONE] = !is_better && change.doubt > 0;
    control[IS_DONE] = gain <= LEAST_GAIN * sum && part >= MOST_PART;
    if (gain < GOOD_GAIN * sum) control[PART] = as_uint(min(MOST_PART, 2.0f * part));
}
