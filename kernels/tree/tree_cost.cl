// The SAH cost of a tree (Aila, Karras, Laine 2013, equation 1), in single precision with compensated sums, in an order
// that depends on the numbering of the nodes alone.
//
// sum_costs
//   in     nodes [node_count] (tree_nodes.clh); the costs of an inner node and of a primitive
//   out    partial_costs [groups]: area times cost over the group's slots, or cost alone where the root has no area;
//          root_area [1]
//   launch a group for SLOTS_PER_GROUP slots
// sum_flat_costs: for sums that are made elsewhere, of area times cost alone
//   in     as sum_costs
//   inout  partial_costs [groups]: cost alone over the group's slots, where the root has no area; else nothing is done
//   launch any number of groups
// divide_costs
//   in     partial_costs [count], root_area
//   out    sah [1]: their sum by the root's area, where it has any
//   launch one group
// local  8 * WORK_GROUP_SIZE bytes
#include "work_group.clh"
#include "aabb.clh"
#include "node.clh"
#include "tree_nodes.clh"
#include "compensated.clh"
#include "node_area.clh"

static inline float2 sum_over_slots(local float2* scratch, global const float* nodes, size_t begin, size_t end,
                                    int every_node_is_hit, float inner_cost, float primitive_cost) {
    float2 sum = (float2)(0.0f, 0.0f);
    for (size_t run = begin; run < end; run += SUM_RUN * WORK_GROUP_SIZE) {
        float part = 0.0f;
        FOR_WORK_ITEMS(slot, run, min(run + SUM_RUN * WORK_GROUP_SIZE, end)) {
            const float8 node = vload8(slot, nodes);
            part += every_node_is_hit ? flat_cost_of(node, inner_cost, primitive_cost)
                                      : node_cost_of(node, inner_cost, primitive_cost);
        }
        sum = add_to_sum(sum, part);
    }
    return sum_over_group(scratch, sum);
}

KERNEL void sum_costs(global const float* nodes, TREE_SIZE_ARGUMENTS, float inner_cost, float primitive_cost,
                      global float2* partial_costs, global float* root_area) {
    local float2 scratch[WORK_GROUP_SIZE];
    const size_t size = TREE_SIZE;
    const size_t begin = get_group_id(0) * (size_t)SLOTS_PER_GROUP;
    const size_t end = min(begin + SLOTS_PER_GROUP, size);
    const float8 root = vload8(0, nodes);
    const float2 sum = sum_over_slots(scratch, nodes, begin, end, is_flat(root), inner_cost, primitive_cost);
    if (LOCAL_ID == 0) {
        partial_costs[get_group_id(0)] = sum;
        if (get_group_id(0) == 0) *root_area = size > 0 ? half_area_of(root) : 0.0f;
    }
}

KERNEL void sum_flat_costs(global const float* nodes, TREE_SIZE_ARGUMENTS, float inner_cost, float primitive_cost,
                           global float2* partial_costs) {
    local float2 scratch[WORK_GROUP_SIZE];
    // The same for all items: none waits at a barrier for one that has left.
    if (!is_flat(vload8(0, nodes))) return;
    const size_t size = TREE_SIZE;
    const size_t share = (size + get_num_groups(0) - 1) / get_num_groups(0);
    const size_t begin = min(get_group_id(0) * share, size);
    const float2 sum = sum_over_slots(scratch, nodes, begin, min(begin + share, size), 1, inner_cost, primitive_cost);
    if (LOCAL_ID == 0) partial_costs[get_group_id(0)] = sum;
}

KERNEL void divide_costs(global const float2* partial_costs, uint count, global const float* root_area,
                         global uchar* sah, ulong sah_offset) {
    local float2 scratch[WORK_GROUP_SIZE];
    float2 sum = (float2)(0.0f, 0.0f);
    FOR_WORK_ITEMS(i, 0, count) {
        sum = add_sums(sum, partial_costs[i]);
    }
    sum = sum_over_group(scratch, sum);
    if (LOCAL_ID == 0) {
        const float area = *root_area;
        *(global float*)(sah + sah_offset) = (sum.x + sum.y) / (area > 0.0f ? area : 1.0f);
    }
}
