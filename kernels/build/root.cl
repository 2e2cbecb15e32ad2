// Completes the node array: the sibling pairs stand already (node.clh), the root pair 0 is missing.
//
// write_root
//   in     root_reference [1], leaf_count [1], primitive_count [1]: the active ones; boxes [.. * 6], primitive_ids
//          [primitive_count]; where boxes_are_sorted, the box of position 0 is box 0, else that of its primitive
//   inout  nodes [2 * leaf_count]; the root of no leaves at all is a box that nothing hits
//   launch one work item
// clear_unused
//   in     leaf_count [1], primitive_count [1]
//   out    nodes: those behind the leaves' own, up to 2 * primitive_count, become zero
//   launch any number of groups
#include "work_group.clh"
#include "aabb.clh"
#include "node.clh"
#include "root.clh"

KERNEL void write_root(global const uint* root_reference, global const uint* leaf_count_in,
                       global const uint* primitive_count_in, global const float* boxes, uint boxes_are_sorted,
                       global const uint* primitive_ids, global Node* nodes) {
    const uint leaf_count = *leaf_count_in;
    const uint primitive_count = *primitive_count_in;
    if (LOCAL_ID == 0) {
        Box all = empty_box();
        for (uint i = 0; leaf_count == 1 && i < primitive_count; ++i) {
            all = merge_boxes(all, load_box(boxes + BOX_FLOATS * (size_t)(boxes_are_sorted ? i : primitive_ids[i])));
        }
        write_root_pair(nodes, *root_reference, leaf_count, primitive_count, all);
    }
}

KERNEL void clear_unused(global const uint* leaf_count_in, global const uint* primitive_count_in, global float* nodes) {
    const size_t leaf_count = *leaf_count_in;
    const size_t unused = *primitive_count_in - leaf_count;
    const size_t begin = leaf_count + unused * get_group_id(0) / get_num_groups(0);
    const size_t end = leaf_count + unused * (get_group_id(0) + 1) / get_num_groups(0);
    FOR_WORK_ITEMS(slot, begin, end) {
        const float16 zeros = 0.0f;
        STREAM_STORE16(zeros, slot, nodes);
    }
}
