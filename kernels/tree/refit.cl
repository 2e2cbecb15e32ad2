// Boxes for a tree whose primitives have moved. Primitives that are inactive count for nothing; a leaf that has none
// but such gets a box that nothing hits and whose area is 0.
//
//   in     boxes [primitives * 6] (bounds.cl), primitive_ids; the order of refit_order.cl
//   inout  nodes [node_count] (tree_nodes.clh): only boxes are written
// refit_ranges (lane shape)
//   out    costs_before, costs_after [REFIT_RANGES + 1]: area times cost of all nodes of the group's range; where the
//          root had no area, costs_before stays. Sums for roots without one are those of sum_flat_costs (tree_cost.cl),
//          made before and after: in here, where they are hardly ever asked for, they took a tenth of the time.
//   launch REFIT_RANGES groups
// refit_top (lane shape), one work item
//   out    the last of either costs; area_before, area_after [1]: the root's
// fit_leaves (group shape)
//   launch a group for SLOTS_PER_GROUP slots
// fit_inner (group shape): one work item a pair of leaves goes up; the second to reach a node goes on
//   inout  arrivals [pairs]: zeros before and after
//   launch any number of groups, which take SLOTS_PER_GROUP / 2 pairs in turn; one, where groups hand nothing over
//   within a launch
#include "work_group.clh"
#include "aabb.clh"
#include "node.clh"
#include "tree_nodes.clh"
#include "compensated.clh"
#include "node_area.clh"
#include "between_groups.clh"

#ifndef REFIT_RANGES
#define REFIT_RANGES 64
#endif

// How far ahead of its use a box is fetched, how much further the id that names it, and how much further the node that
// names that.
#ifndef REFIT_AHEAD
#define REFIT_AHEAD 16
#endif

static inline float8 fitted_leaf(float8 leaf, global const uint* primitive_ids, global const float* boxes) {
    const uint first = FIRST_OF(leaf);
    const uint end = first + COUNT_OF(leaf);
    float4 lower = (float4)(INFINITY);
    float4 upper = (float4)(-INFINITY);
    for (uint i = first; i < end; ++i) {
        global const float* const box = boxes + BOX_FLOATS * (size_t)primitive_ids[i];
        const float4 box_lower = vload4(0, box);
        const float4 box_upper = vload4(0, box + 2);
        // An inactive one is NaN, and so never smaller or larger.
        lower = MIN_OF(box_lower, lower);
        upper = MAX_OF(box_upper, upper);
    }
    return (float8)(lower.s012, leaf.s3, upper.s123, leaf.s7);
}

#if LANE_SHAPE

typedef struct {
    float2 before, after;         // of whole runs of pairs
    float run_before, run_after;  // of the run at hand
    float inner_cost, primitive_cost;
} Costs;

static inline void add_costs(Costs* costs, float8 before, float8 after) {
    costs->run_before += node_cost_of(before, costs->inner_cost, costs->primitive_cost);
    costs->run_after += node_cost_of(after, costs->inner_cost, costs->primitive_cost);
}

static inline void end_run(Costs* costs) {
    costs->before = add_to_sum(costs->before, costs->run_before);
    costs->after = add_to_sum(costs->after, costs->run_after);
    costs->run_before = costs->run_after = 0.0f;
}

// The box of the parent of a pair, whose children's boxes stand already unless they are leaves.
static inline void refit_pair(global float* nodes, uint2 place, global const uint* primitive_ids,
                              global const float* boxes, Costs* costs) {
    const size_t left_slot = 2 * (size_t)place.x;
    const float8 old_left = vload8(left_slot, nodes);
    const float8 old_right = vload8(left_slot + 1, nodes);
    float8 left = old_left;
    float8 right = old_right;
    if (COUNT_OF(left) > 0) {
        left = fitted_leaf(left, primitive_ids, boxes);
        vstore8(left, left_slot, nodes);
        add_costs(costs, old_left, left);
    }
    if (COUNT_OF(right) > 0) {
        right = fitted_leaf(right, primitive_ids, boxes);
        vstore8(right, left_slot + 1, nodes);
        add_costs(costs, old_right, right);
    }
    const float8 old_parent = vload8(place.y, nodes);
    const float8 lower = MIN_OF(left, right);
    const float8 upper = MAX_OF(left, right);
    const float8 parent = (float8)(lower.s012, old_parent.s3, upper.s456, old_parent.s7);
    vstore8(parent, place.y, nodes);
    add_costs(costs, old_parent, parent);
}

static inline void fetch_ahead(global const float* nodes, global const uint2* order, uint i, uint begin,
                               global const uint* primitive_ids, global const float* boxes) {
    const uint farthest = max(i, begin + 3 * REFIT_AHEAD) - 3 * REFIT_AHEAD;
    PREFETCH(nodes + 16 * (size_t)order[farthest].x);
    const uint farther = max(i, begin + 2 * REFIT_AHEAD) - 2 * REFIT_AHEAD;
    global const uint* pair = (global const uint*)nodes + 16 * (size_t)order[farther].x;
    if (pair[7] > 0) PREFETCH(primitive_ids + pair[3]);
    if (pair[15] > 0) PREFETCH(primitive_ids + pair[11]);
    const uint far = max(i, begin + REFIT_AHEAD) - REFIT_AHEAD;
    pair = (global const uint*)nodes + 16 * (size_t)order[far].x;
    if (pair[7] > 0) PREFETCH(boxes + BOX_FLOATS * (size_t)primitive_ids[pair[3]]);
    if (pair[15] > 0) PREFETCH(boxes + BOX_FLOATS * (size_t)primitive_ids[pair[11]]);
}

static inline void refit_range(global float* nodes, global const uint2* order, uint begin, uint end,
                               global const uint* primitive_ids, global const float* boxes, Costs* costs) {
    while (end > begin) {
        const uint run_begin = max(end, begin + SUM_RUN) - SUM_RUN;
        for (uint i = end; i-- > run_begin;) {
            fetch_ahead(nodes, order, i, begin, primitive_ids, boxes);
            refit_pair(nodes, order[i], primitive_ids, boxes, costs);
        }
        end_run(costs);
        end = run_begin;
    }
}

KERNEL void refit_ranges(global float* nodes, global const uint2* order, global const uint* ranges,
                         global const uint* primitive_ids, global const float* boxes, float inner_cost,
                         float primitive_cost, global float2* costs_before, global float2* costs_after) {
    const size_t range = get_group_id(0);
    // The root is refit_top's to write.
    const int was_flat = is_flat(vload8(0, nodes));
    Costs costs = {(float2)(0.0f), (float2)(0.0f), 0.0f, 0.0f, inner_cost, primitive_cost};
    refit_range(nodes, order, ranges[range + 1], ranges[range], primitive_ids, boxes, &costs);
    if (!was_flat) costs_before[range] = costs.before;
    costs_after[range] = costs.after;
}

KERNEL void refit_top(global float* nodes, TREE_SIZE_ARGUMENTS, global const uint2* order, global const uint* ranges,
                      global const uint* primitive_ids, global const float* boxes, float inner_cost,
                      float primitive_cost, global float2* costs_before, global float2* costs_after,
                      global float* area_before, global float* area_after) {
    const int is_there = TREE_SIZE > 0;
    const float8 root = vload8(0, nodes);
    Costs costs = {(float2)(0.0f), (float2)(0.0f), 0.0f, 0.0f, inner_cost, primitive_cost};
    const uint pairs = ranges[REFIT_RANGES];
    *area_before = is_there ? half_area_of(root) : 0.0f;
    refit_range(nodes, order, 0, pairs, primitive_ids, boxes, &costs);
    if (is_there && COUNT_OF(root) > 0) {
        const float8 fitted = fitted_leaf(root, primitive_ids, boxes);
        vstore8(fitted, 0, nodes);
        add_costs(&costs, root, fitted);
        end_run(&costs);
    }
    *area_after = is_there ? half_area_of(vload8(0, nodes)) : 0.0f;
    if (!is_flat(root)) costs_before[REFIT_RANGES] = costs.before;
    costs_after[REFIT_RANGES] = costs.after;
}

#else

KERNEL void fit_leaves(global float* nodes, TREE_SIZE_ARGUMENTS, global const uint* primitive_ids,
                       global const float* boxes) {
    const size_t size = TREE_SIZE;
    const size_t begin = get_group_id(0) * (size_t)SLOTS_PER_GROUP;
    FOR_WORK_ITEMS(slot, begin, min(begin + SLOTS_PER_GROUP, size)) {
        const float8 node = vload8(slot, nodes);
        if (COUNT_OF(node) > 0) vstore8(fitted_leaf(node, primitive_ids, boxes), slot, nodes);
    }
}

static inline Box box_of_node(global const uint* node) {
    Box box = {as_float(node[0]), as_float(node[1]), as_float(node[2]),
               as_float(node[4]), as_float(node[5]), as_float(node[6])};
    return box;
}

// `pair` is one of two leaves.
static inline void fit_upwards(global uint* nodes, global const uint* parents, global uint* arrivals, uint pair) {
    global uint* node = nodes + 16 * (size_t)pair;
    Box box = merge_boxes(box_of_node(node), box_of_node(node + 8));
    for (;;) {
        const uint slot = parents[pair];
        publish_box(nodes + 8 * (size_t)slot, box);
        if (slot == ROOT_SLOT) return;
        pair = slot / 2;
        global uint* const sibling = nodes + 8 * (size_t)SIBLING_OF(slot);
        if (sibling[7] > 0) {
            box = merge_boxes(box, box_of_node(sibling));
            continue;
        }
        DEVICE_FENCE();
        if (atomic_xchg(arrivals + pair, 1u) == 0) return;
        DEVICE_FENCE();
        publish_word(arrivals + pair, 0u);
        box = merge_boxes(box, observe_box(sibling));
    }
}

KERNEL void fit_inner(global uint* nodes, TREE_SIZE_ARGUMENTS, global const uint* parents, global uint* arrivals) {
    const size_t pairs = TREE_SIZE / 2;
    const size_t step = SLOTS_PER_GROUP / 2;
    for (size_t begin = get_group_id(0) * step; begin < pairs; begin += get_num_groups(0) * step) {
        FOR_WORK_ITEMS(pair, begin, min(begin + step, pairs)) {
            if (pair > 0 && nodes[16 * pair + 7] > 0 && nodes[16 * pair + 15] > 0) {
                fit_upwards(nodes, parents, arrivals, (uint)pair);
            }
        }
    }
}

#endif
