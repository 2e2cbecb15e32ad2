// How many leaves are below each node of a finished tree, and which of its subtrees can be restructured at once.
//
// clear_words
//   out    words [count], zeros
//   launch a group for SLOTS_PER_GROUP words
// count_leaves
//   in     nodes [node_count] (tree_nodes.clh), parents [node_count / 2] (parents.cl)
//   inout  sizes [node_count / 2], zero before: of the sibling pair p, the leaves below its two nodes
//   launch a group for SLOTS_PER_GROUP slots; the second of two siblings to arrive goes on with the parent
// list_subtrees
//   in     nodes, sizes; least_size, what a treelet's root has below it at least
//   inout  list_counts [LEVELS], zero before: subtrees of each level (treelet_walk.clh)
//   out    lists: the roots of each level from list_begin() on, in any order
//   launch a group for SLOTS_PER_GROUP slots
#include "work_group.clh"
#include "aabb.clh"
#include "node.clh"
#include "tree_nodes.clh"
#include "treelet_walk.clh"

KERNEL void clear_words(global uint* words, uint count) {
    const size_t begin = get_group_id(0) * (size_t)SLOTS_PER_GROUP;
    FOR_WORK_ITEMS(k, begin, min(begin + SLOTS_PER_GROUP, (size_t)count)) {
        words[k] = 0;
    }
}

// Adds `size`, the leaves below the node `slot`, to those of its pair, and where the sibling's were there already, goes
// on with the parent.
static inline void count_upwards(global uint* sizes, global const uint* parents, uint slot, uint size) {
    while (slot != ROOT_SLOT) {
        const uint of_sibling = atomic_add(sizes + slot / 2, size);
        if (of_sibling == 0) return;
        size += of_sibling;
        slot = parents[slot / 2];
    }
}

KERNEL void count_leaves(global const float* nodes, TREE_SIZE_ARGUMENTS, global const uint* parents,
                         global uint* sizes) {
    const size_t pairs = TREE_SIZE / 2;
    const size_t begin = get_group_id(0) * (size_t)(SLOTS_PER_GROUP / 2);
    FOR_WORK_ITEMS(pair, begin, min(begin + SLOTS_PER_GROUP / 2, pairs)) {
        const int left_is_leaf = COUNT_AT(nodes, 2 * pair) > 0;
        const int right_is_leaf = COUNT_AT(nodes, 2 * pair + 1) > 0;
        if (pair == 0) continue;
        if (left_is_leaf && right_is_leaf) {
            sizes[pair] = 2;
            count_upwards(sizes, parents, parents[pair], 2);
        } else if (left_is_leaf || right_is_leaf) {
            count_upwards(sizes, parents, (uint)(2 * pair), 1);
        }
    }
}

static inline void append(global uint* lists, global uint* list_counts, uint leaf_capacity, uint least_size, uint level,
                          uint slot) {
    lists[list_begin(leaf_capacity, least_size, level) + atomic_inc(list_counts + level)] = slot;
}

KERNEL void list_subtrees(global const float* nodes, TREE_SIZE_ARGUMENTS, global const uint* sizes, uint least_size,
                          global uint* lists, global uint* list_counts) {
    const size_t pairs = TREE_SIZE / 2;
    const uint leaf_capacity = node_count / 2;
    const size_t begin = get_group_id(0) * (size_t)(SLOTS_PER_GROUP / 2);
    FOR_WORK_ITEMS(pair, begin, min(begin + SLOTS_PER_GROUP / 2, pairs)) {
        if (pair == 0) {
            const uint size = size_below(nodes, sizes, ROOT_SLOT);
            if (size >= least_size) append(lists, list_counts, leaf_capacity, least_size, level_of(size), ROOT_SLOT);
            continue;
        }
        const uint level_of_parent = level_of(sizes[pair]);
        if (level_of_parent == 0) continue;
        for (uint slot = 2 * (uint)pair; slot < 2 * (uint)pair + 2; ++slot) {
            const uint size = size_below(nodes, sizes, slot);
            const uint level = level_of(size);
            if (size < least_size || level == level_of_parent) continue;
            append(lists, list_counts, leaf_capacity, least_size, level, slot);
        }
    }
}
