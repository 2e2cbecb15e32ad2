// Completes the node array: the sibling pairs stand already (node.clh), the root pair 0 is missing.
//
//   in     root_reference [1], leaves [leaf_count * 6]
//   inout  nodes [2 * leaf_count]
//   launch one work item
#include "work_group.clh"
#include "aabb.clh"
#include "node.clh"

KERNEL void write_root(global const uint* root_reference, uint leaf_count, global const float* leaves,
                       global Node* nodes) {
    if (LOCAL_ID == 0) {
        const uint reference = *root_reference;
        Node root = {{0.0f, 0.0f, 0.0f},
                     node_first(reference, leaf_count),
                     {0.0f, 0.0f, 0.0f},
                     node_count(reference, leaf_count)};
        for (uint axis = 0; axis < 3; ++axis) {
            if (root.count > 0) {
                root.lower[axis] = leaves[axis];
                root.upper[axis] = leaves[3 + axis];
            } else {
                root.lower[axis] = MIN_OF(nodes[root.first].lower[axis], nodes[root.first + 1].lower[axis]);
                root.upper[axis] = MAX_OF(nodes[root.first].upper[axis], nodes[root.first + 1].upper[axis]);
            }
        }
        nodes[0] = root;
        const Node unused = {{0.0f, 0.0f, 0.0f}, 0, {0.0f, 0.0f, 0.0f}, 0};
        nodes[1] = unused;
    }
}
