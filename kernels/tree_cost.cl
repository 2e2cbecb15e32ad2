// The SAH cost of a tree (Aila, Karras, Laine 2013, equation 1), in single precision with compensated sums, in an order
// that depends on the numbering of the nodes alone.
//
// sum_costs
//   in     nodes [node_count] (tree_nodes.clh); the costs of an inner node and of a primitive
//   out    partial_costs [groups]: area times cost over the group's slots; root_area [1]
//   launch a group for SLOTS_PER_GROUP slots
// divide_costs
//   in     partial_costs [count], root_area
//   out    sah [1]: their sum by the root's area; 0 where that is 0
//   launch one group
// local  8 * WORK_GROUP_SIZE bytes
#include "work_group.clh"
#include "aabb.clh"
#include "node.clh"
#include "tree_nodes.clh"
#include "compensated.clh"
#include "node_area.clh"

KERNEL void sum_costs(global const float* nodes, TREE_SIZE_ARGUMENTS, float inner_cost, float primitive_cost,
                      global float2* partial_costs, global float* root_area) {
    local float2 scratch[WORK_GROUP_SIZE];
    const size_t size = TREE_SIZE;
    const size_t begin = get_group_id(0) * (size_t)SLOTS_PER_GROUP;
    const size_t end = min(begin + SLOTS_PER_GROUP, size);
    float2 sum = (float2)(0.0f, 0.0f);
    for (size_t run = begin; run < end; run += SUM_RUN * WORK_GROUP_SIZE) {
        float part = 0.0f;
        FOR_WORK_ITEMS(slot, run, min(run + SUM_RUN * WORK_GROUP_SIZE, end)) {
            part += node_cost_of(vload8(slot, nodes), inner_cost, primitive_cost);
        }
        sum = add_to_sum(sum, part);
    }
    sum = sum_over_group(scratch, sum);
    if (LOCAL_ID == 0) {
        partial_costs[get_group_id(0)] = sum;
        if (get_group_id(0) == 0) *root_area = size > 0 ? half_area_of(vload8(0, nodes)) : 0.0f;
    }
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
        *(global float*)(sah + sah_offset) = area > 0.0f ? (sum.x + sum.y) / area : 0.0f;
    }
}
