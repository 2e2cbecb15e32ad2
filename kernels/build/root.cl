// Completes the node array: the sibling pairs stand already (node.clh), the root pair 0 is missing.
//
//   in     root_reference [1], leaf_count [1], boxes [.. * 6], primitive_ids [leaf_count]; where boxes_are_sorted, the
//          box of leaf 0 is box 0, else that of its primitive
//   inout  nodes [2 * leaf_count]; the root of no leaves at all is a box that nothing hits
//   launch one work item
#include "work_group.clh"
#include "aabb.clh"
#include "node.clh"
#include "root.clh"

KERNEL void write_root(global const uint* root_reference, global const uint* leaf_count_in, global const float* boxes,
                       uint boxes_are_sorted, global const uint* primitive_ids, global Node* nodes) {
    const uint leaf_count = *leaf_count_in;
    if (LOCAL_ID == 0) {
        const uint only_box = boxes_are_sorted || leaf_count == 0 ? 0 : primitive_ids[0];
        write_root_pair(nodes, *root_reference, leaf_count, boxes + BOX_FLOATS * (size_t)only_box);
    }
}
