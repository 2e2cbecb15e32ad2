// The initial clusters: boxes of the active primitives in Morton order.
//
// gather_leaves
//   in     boxes [.. * 6], primitive_ids [leaf_count] in Morton order, leaf_count [1]
//   out    leaves [leaf_count * 6 + 2]: the two words behind the last box are zero (cluster.clh)
//   launch groups of WORK_GROUP_SIZE, each on piece_length leaves; those beyond the last one are idle
// number_leaves
//   out    references [leaf_count]: cluster i is leaf i
#include "work_group.clh"
#include "aabb.clh"

// How far ahead of their use a gathered box and the id that leads to it are fetched.
#ifndef LEAF_AHEAD
#define LEAF_AHEAD 32
#endif
#ifndef LEAF_ID_AHEAD
#define LEAF_ID_AHEAD 128
#endif

KERNEL void gather_leaves(global const float* boxes, global const uint* primitive_ids, global const uint* leaf_count_in,
                          uint piece_length, global float* leaves) {
    const uint leaf_count = *leaf_count_in;
    const size_t begin = get_group_id(0) * (size_t)piece_length;
    const size_t end = min(begin + piece_length, (size_t)leaf_count);
    FOR_WORK_ITEMS(i, begin, end) {
        PREFETCH(primitive_ids + i + LEAF_ID_AHEAD);
        PREFETCH(boxes + BOX_FLOATS * (size_t)primitive_ids[min(i + LEAF_AHEAD, end - 1)]);
        // Two vectors, since a box is only moved: six floats one by one take a fifth longer on PoCL.
        global const float* box = boxes + BOX_FLOATS * (size_t)primitive_ids[i];
        const float4 first = vload4(0, box);
        const float2 last = vload2(2, box);
        vstore4(first, 0, leaves + BOX_FLOATS * i);
        vstore2(last, 2, leaves + BOX_FLOATS * i);
    }
    if (begin < end && end == leaf_count) {
        FOR_WORK_ITEMS(k, 0, 2) {
            leaves[BOX_FLOATS * (size_t)leaf_count + k] = 0.0f;
        }
    }
}

KERNEL void number_leaves(global const uint* leaf_count_in, uint piece_length, global uint* references) {
    const uint leaf_count = *leaf_count_in;
    const size_t begin = get_group_id(0) * (size_t)piece_length;
    const size_t end = min(begin + piece_length, (size_t)leaf_count);
    FOR_WORK_ITEMS(i, begin, end) {
        references[i] = (uint)i;
    }
}
