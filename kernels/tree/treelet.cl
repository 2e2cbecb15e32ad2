// Treelet restructuring: Karras, Aila 2013, "Fast Parallel Construction of High-Quality Bounding Volume Hierarchies",
// section 3. The treelet of a node is a small tree at its top: from the node on, the largest leaf that is an inner node
// of the tree is taken apart until there are TREELET_LEAVES. It is replaced by the best of all binary trees over these
// leaves, where that is better. Leaves of the tree stay as they are.
//
// restructure
//          the treelets of all nodes of one level of size (treelet_walk.clh), children before parents
//   in     lists, list_counts [LEVELS] (treelet_sizes.cl); least_size as there, at least TREELET_LEAVES
//   inout  nodes [node_count], parents [node_count / 2] (parents.cl), sizes [node_count / 2] (treelet_sizes.cl)
//   launch group shape: any number of groups, each takes subtrees in turn and a treelet at a time (treelet_group.clh).
//          lane shape: any number of work items, each takes a part of the list, 16 treelets at a time
//          (treelet_lane.clh).
//   local  3 KiB (group), 30.1 KiB (lane); with 8 leaves 5 KiB and 52.1 KiB, more than some devices have
//
// A treelet depends on what is below its root alone, so that the order of subtrees and the shape do not matter.
#include "work_group.clh"
#include "aabb.clh"
#include "bits.clh"
#include "node.clh"
#include "tree_nodes.clh"
#include "treelet_walk.clh"

#ifndef TREELET_LEAVES
#define TREELET_LEAVES 7
#endif

// A subset of a treelet's leaves is a number whose bit i stands for leaf i.
#define SUBSETS (1u << TREELET_LEAVES)
#define ALL_LEAVES (SUBSETS - 1)
#define HAS_ONE_LEAF(subset) (((subset) & ((subset)-1)) == 0)

// The areas of a treelet are sums of at most six half areas. The rounding of a difference of corners, of the half area
// and of the sum makes each wrong by at most 10 units of 2^-24, or by less than 1e-36 where numbers vanish. What is
// better by more than that in single precision is better.
#define IS_LESS_AREA(a, b) ((a) + 1e-36f < (b)*0.999998f)

// The area that says which leaf is taken apart; negative for leaves of the tree.
static inline float area_to_take_apart(float8 node) {
    if (!is_inner(as_uint(node.s3), as_uint(node.s7))) return -1.0f;
    const float x = EXTENT_OF(node.s0, node.s4);
    const float y = EXTENT_OF(node.s1, node.s5);
    const float z = EXTENT_OF(node.s2, node.s6);
    return HALF_AREA(x, y, z);
}

// The arrays that restructuring keeps right.
typedef struct {
    global float* nodes;
    global uint* parents;
    global uint* sizes;
} Tree;

// Writes the root of the best tree over `subset`, some of the treelet's `leaves`, to `slot`: that leaf, or an inner
// node with children at `first`.
static inline void write_node(Tree tree, local const float8* leaves, uint slot, uint subset, uint first) {
    const float8 lowest = leaves[LOWEST_BIT(subset)];
    if (HAS_ONE_LEAF(subset)) {
        vstore8(lowest, slot, tree.nodes);
        const uint below = as_uint(lowest.s3);
        if (is_inner(below, as_uint(lowest.s7))) tree.parents[below / 2] = slot;
        return;
    }
    float8 lower = lowest, upper = lowest;
    uint size = 0;
    for (uint rest = subset; rest != 0; rest &= rest - 1) {
        const float8 leaf = leaves[LOWEST_BIT(rest)];
        lower = MIN_OF(lower, leaf);
        upper = MAX_OF(upper, leaf);
        const uint below = as_uint(leaf.s3);
        size += is_inner(below, as_uint(leaf.s7)) ? tree.sizes[below / 2] : 1;
    }
    vstore8((float8)(lower.s012, as_float(first), upper.s456, as_float(0u)), slot, tree.nodes);
    tree.parents[first / 2] = slot;
    tree.sizes[first / 2] = size;
}

#if LANE_SHAPE
#include "treelet_lane.clh"
#else
#include "treelet_group.clh"
#endif
