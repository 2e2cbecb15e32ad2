// Parent links of a finished tree.
//
// find_parents
//   in     nodes [node_count] (tree_nodes.clh)
//   out    parents [node_count / 2]: of the sibling pair p, in slots 2 p and 2 p + 1, the slot of the parent; of pairs
//          that no node uses, and of the root's, nothing is written
//   launch a group for SLOTS_PER_GROUP slots
#include "work_group.clh"
#include "aabb.clh"
#include "node.clh"
#include "tree_nodes.clh"

KERNEL void find_parents(global const Node* nodes, TREE_SIZE_ARGUMENTS, global uint* parents) {
    const size_t size = TREE_SIZE;
    const size_t begin = get_group_id(0) * (size_t)SLOTS_PER_GROUP;
    FOR_WORK_ITEMS(slot, begin, min(begin + SLOTS_PER_GROUP, size)) {
        const uint first = nodes[slot].first;
        if (is_inner(first, nodes[slot].count)) parents[first / 2] = (uint)slot;
    }
}
