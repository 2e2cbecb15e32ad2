#pragma once

#include <cstddef>
#include <cstdint>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"
#include "clbvh/export.h"
#include "clbvh/layout/layout_array.hpp"
#include "clbvh/layout/make_layout.hpp"

namespace clbvh {

/// One node of a PairLayout; 64 bytes, little-endian. A leaf has a node of its own, whose boxes are zero.
///
/// | bytes | what |
/// |---|---|
/// | 0 .. 11 | float32 lower x y z of the left child's box |
/// | 12 .. 15 | uint32 number of the left child's node |
/// | 16 .. 27 | float32 upper x y z of the left child's box |
/// | 28 .. 31 | uint32 number of the right child's node |
/// | 32 .. 43 | float32 lower x y z of the right child's box |
/// | 44 .. 47 | uint32 primitives of a leaf; 0: an inner node |
/// | 48 .. 59 | float32 upper x y z of the right child's box |
/// | 60 .. 63 | uint32 first place of a leaf in primitive_ids |
struct PairNode {
    float left_lower[3];
    std::uint32_t left;
    float left_upper[3];
    std::uint32_t right;
    float right_lower[3];
    std::uint32_t count;
    float right_upper[3];
    std::uint32_t first;

    [[nodiscard]] constexpr bool is_leaf() const noexcept { return count > 0; }
    [[nodiscard]] constexpr Aabb left_bounds() const noexcept {
        return {{left_lower[0], left_lower[1], left_lower[2]}, {left_upper[0], left_upper[1], left_upper[2]}};
    }
    [[nodiscard]] constexpr Aabb right_bounds() const noexcept {
        return {{right_lower[0], right_lower[1], right_lower[2]}, {right_upper[0], right_upper[1], right_upper[2]}};
    }
    friend constexpr bool operator==(const PairNode&, const PairNode&) = default;
};
static_assert(sizeof(PairNode) == 64 && offsetof(PairNode, right) == 28 && offsetof(PairNode, first) == 60);

/// Nodes that hold the boxes of their two children, so that one fetch decides about both: Aila, Laine 2009,
/// "Understanding the Efficiency of Ray Traversal on GPUs". Byte for byte the nodes and ids of tinybvh's BVH_GPU.
/// Depth-first: the left child is the node behind its parent.
struct PairLayout {
    LayoutArray<PairNode> nodes;               ///< The root is the first; empty for an empty tree.
    LayoutArray<std::uint32_t> primitive_ids;  ///< Leaf after leaf, in the order of the nodes, without gaps.
    std::uint32_t depth = 0;                   ///< Edges on the longest path; a stack holds no more nodes than that.
    std::uint64_t primitive_count = 0;         ///< Of the input; every id is below it.
    bool split_references = false;             ///< As of the tree: see Bvh.

    [[nodiscard]] bool empty() const noexcept { return nodes.empty(); }
    /// Empties it, and keeps its memory.
    void clear() noexcept {
        nodes.clear();
        primitive_ids.clear();
        depth = 0;
        primitive_count = 0;
        split_references = false;
    }
};

/// Lays a tree out, over primitives of any kind, with all threads; the same bytes with any number of them. `result` is
/// made anew in the memory that it has. Trees are checked whatever the options say: it costs next to nothing here.
/// Throws Error(invalid_input) naming the first offender where the tree is none: links or ids out of range, or loops;
/// Error(out_of_memory). `result` is then empty.
CLBVH_API void make_layout(const Bvh& bvh, PairLayout& result, const LayoutOptions& options = {});

/// Gives a layout the boxes that its primitives, triangles or boxes, ask for where they are now, in place and with all
/// threads; its structure stays. The bytes are those of make_layout of the tree after clbvh::refit. O(n) time. No ray
/// may be traced through it meanwhile.
///
/// The layout is one that make_layout() made, or that validate() has proven; its structure is not checked here.
/// `primitives` are as many as it was made over. Leaves get the boxes of whole primitives, also where
/// references were split. What is NaN is left out of the boxes. Boxes only get worse from frame to frame: see
/// docs/layouts.md for when to build anew.
/// Throws what check_primitives throws (unless `options` trust the primitives), and Error(invalid_input) for another
/// number of them; the layout is then as it was. Throws Error(out_of_memory), with some boxes old and some new.
CLBVH_API void refit(PairLayout& layout, const Primitives& primitives, const LayoutOptions& options = {});

/// Proves that the layout is a tree over the primitives: children and ranges as documented, every active primitive in
/// one leaf (or, with split references, covered by its leaves), inactive ones in none, and every box around all that is
/// below. Throws Error(invalid_input) naming the first offender. Never reads out of range. O(n) time and memory, and
/// for split references that of clbvh::validate.
CLBVH_API void validate(const PairLayout& layout, const Primitives& primitives);

}  // namespace clbvh
