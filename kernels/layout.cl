// Completes the node array: the sibling pairs stand already (node.clh), the root pair 0 is missing.
//
//   in     root_reference [1], leaf_count [1], boxes [.. * 6], primitive_ids [leaf_count]; where boxes_are_sorted, the
//          box of leaf 0 is box 0, else that of its primitive
//   inout  nodes [2 * leaf_count]; the root of no leaves at all is a box that nothing hits
//   launch one work item
#include "work_group.clh"
#include "aabb.clh"
#include "node.clh"

KERNEL void write_root(global const uint* root_reference, global const uint* leaf_count_in, global const float* boxes,
                       uint boxes_are_sorted, global const uint* primitive_ids, global Node* nodes) {
    const uint leaf_count = *leaf_count_in;
    if (LOCAL_ID == 0) {
        const Node unused = {{0.0f, 0.0f, 0.0f}, 0, {0.0f, 0.0f, 0.0f}, 0};
        nodes[1] = unused;
        if (leaf_count == 0) {
            const Node nothing = {{INFINITY, INFINITY, INFINITY}, 0, {-INFINITY, -INFINITY, -INFINITY}, 0};
            nodes[0] = nothing;
            return;
        }
        const uint reference = *root_reference;
        global const float* only_box = boxes + BOX_FLOATS * (size_t)(boxes_are_sorted ? 0 : primitive_ids[0]);
        Node root = {{0.0f, 0.0f, 0.0f},
                     node_first(reference, leaf_count),
                     {0.0f, 0.0f, 0.0f},
                     node_count(reference, leaf_count)};
        for (uint axis = 0; axis < 3; ++axis) {
            if (root.count > 0) {
                root.lower[axis] = only_box[axis];
                root.upper[axis] = only_box[3 + axis];
            } else {
                root.lower[axis] = MIN_OF(nodes[root.first].lower[axis], nodes[root.first + 1].lower[axis]);
                root.upper[axis] = MAX_OF(nodes[root.first].upper[axis], nodes[root.first + 1].upper[axis]);
            }
        }
        nodes[0] = root;
    }
}
