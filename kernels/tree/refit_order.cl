// A tree's structure, as refitting needs it: the parents of all sibling pairs, and in the lane shape an order of the
// pairs in which children stand behind their parents.
//
//   in     nodes [node_count] (tree_nodes.clh), parents [pairs] (parents.cl), pairs = node_count / 2
// clear_arrivals
//   out    arrivals [pairs]: zeros
// measure_subtrees (lane shape)
//   inout  arrivals: then the number of pairs of the subtree that begins with each
//   launch a group for SLOTS_PER_GROUP slots, as clear_arrivals
// plan_order (lane shape), one work item
//   in     sizes, as measure_subtrees leaves them
//   out    order [pairs]: (pair, slot of its parent). In front the root's and others at the top of the tree, behind
//   them
//          subtrees that are small enough to be one work item's, of which only the first pair is set
//          ranges [REFIT_RANGES + 1]: borders of equal parts of these subtrees, from the end down to the top's end
// write_order (lane shape)
//   inout  order: the rest of each subtree
//   launch REFIT_RANGES groups
#include "work_group.clh"
#include "aabb.clh"
#include "node.clh"
#include "tree_nodes.clh"

// Work items for the subtrees, and how many subtrees each has at least where the tree is even.
#ifndef REFIT_RANGES
#define REFIT_RANGES 64
#endif
#define SUBTREES_PER_RANGE 16

KERNEL void clear_arrivals(uint pair_count, global uint* arrivals) {
    const size_t begin = get_group_id(0) * (size_t)(SLOTS_PER_GROUP / 2);
    FOR_WORK_ITEMS(pair, begin, min(begin + SLOTS_PER_GROUP / 2, (size_t)pair_count)) {
        arrivals[pair] = 0;
    }
}

#if LANE_SHAPE

static inline int is_inner_slot(global const Node* nodes, uint slot) {
    return is_inner(nodes[slot].first, nodes[slot].count);
}

// Goes up from a pair of leaves as long as all below is measured. Who finds nothing in the sum of two inner children
// was first, and leaves the rest to the other.
static inline void measure_upwards(global const Node* nodes, global const uint* parents, global uint* sizes,
                                   uint pair) {
    uint size = 1;
    atomic_xchg(sizes + pair, size);
    for (uint slot = parents[pair]; slot != ROOT_SLOT; slot = parents[slot / 2]) {
        if (is_inner_slot(nodes, SIBLING_OF(slot))) {
            const uint other = atomic_add(sizes + slot / 2, size);
            if (other == 0) return;
            size += other;
        }
        atomic_xchg(sizes + slot / 2, ++size);
    }
}

KERNEL void measure_subtrees(global const Node* nodes, TREE_SIZE_ARGUMENTS, global const uint* parents,
                             global uint* sizes) {
    const uint pairs = TREE_SIZE / 2;
    const uint begin = max(1u, (uint)get_group_id(0) * (SLOTS_PER_GROUP / 2));
    const uint end = min(((uint)get_group_id(0) + 1) * (SLOTS_PER_GROUP / 2), pairs);
    for (uint pair = begin; pair < end; ++pair) {
        // Slots that are not used count nothing.
        if (nodes[2 * pair].count > 0 && nodes[2 * pair + 1].count > 0) {
            measure_upwards(nodes, parents, sizes, pair);
        }
    }
}

KERNEL void plan_order(global const Node* nodes, TREE_SIZE_ARGUMENTS, global const uint* sizes, global uint2* order,
                       global uint* ranges) {
    uint top = 0;  // pairs in front, of which those before `next` are done
    uint begin = 0;
    uint range = 0;
    ranges[0] = 0;
    if (TREE_SIZE > 0 && is_inner_slot(nodes, ROOT_SLOT)) {
        const uint pairs = sizes[nodes[ROOT_SLOT].first / 2];
        const uint most = max(1u, pairs / (REFIT_RANGES * SUBTREES_PER_RANGE));
        const uint range_length = pairs / REFIT_RANGES + 1;
        ranges[0] = begin = pairs;
        uint next = 0;
        uint slot = ROOT_SLOT;
        for (;;) {
            // The pair below `slot`, where there is one, is put in front or behind.
            if (is_inner_slot(nodes, slot)) {
                const uint pair = nodes[slot].first / 2;
                if (sizes[pair] > most || slot == ROOT_SLOT) {
                    order[top++] = (uint2)(pair, slot);
                } else {
                    begin -= sizes[pair];
                    order[begin] = (uint2)(pair, slot);
                    if (pairs - begin >= (range + 1) * range_length) ranges[++range] = begin;
                }
            }
            // Left children are those at even slots; behind the right one comes the next pair.
            if (slot != ROOT_SLOT && slot % 2 == 0) {
                ++slot;
            } else {
                if (next == top) break;
                slot = 2 * order[next++].x;
            }
        }
    }
    while (range < REFIT_RANGES)
        ranges[++range] = begin;
}

KERNEL void write_order(global const Node* nodes, global const uint* sizes, global uint2* order,
                        global const uint* ranges) {
    const uint end = ranges[get_group_id(0)];
    for (uint i = ranges[get_group_id(0) + 1]; i < end; ++i) {
        const uint left = 2 * order[i].x;
        uint next = i + 1;
        if (is_inner_slot(nodes, left)) {
            order[next] = (uint2)(nodes[left].first / 2, left);
            next += sizes[nodes[left].first / 2];
        }
        if (is_inner_slot(nodes, left + 1)) order[next] = (uint2)(nodes[left + 1].first / 2, left + 1);
    }
}

#endif
