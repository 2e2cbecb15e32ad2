#pragma once

#include <cstddef>
#include <cstdint>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"
#include "clbvh/export.h"
#include "clbvh/layout/layout_array.hpp"
#include "clbvh/layout/make_layout.hpp"

namespace clbvh {

/// One node of a SkipLayout; 32 bytes, little-endian.
///
/// | bytes | what |
/// |---|---|
/// | 0 .. 11 | float32 lower x y z of the node's own box |
/// | 12 .. 15 | uint32 of an inner node: the number of the node behind all that are below it; of a leaf: its first
/// place in primitive_ids | | 16 .. 27 | float32 upper x y z | | 28 .. 31 | uint32 primitives of a leaf; 0: an inner
/// node |
struct SkipNode {
    float lower[3];
    std::uint32_t link;
    float upper[3];
    std::uint32_t count;

    [[nodiscard]] constexpr bool is_leaf() const noexcept { return count > 0; }
    [[nodiscard]] constexpr Aabb bounds() const noexcept {
        return {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}};
    }
    friend constexpr bool operator==(const SkipNode&, const SkipNode&) = default;
};
static_assert(sizeof(SkipNode) == 32 && offsetof(SkipNode, upper) == 16);

/// A tree in depth-first order with skip links, for traversals without a stack: the node behind an inner node is its
/// first child, and its second child is behind all that are below the first. Boxes are those of the binary tree.
///
///     for (std::uint32_t i = 0; i < nodes.size();) {
///         const clbvh::SkipNode& node = nodes[i];
///         const bool is_met = meets(ray, node.lower, node.upper);
///         if (is_met && node.is_leaf()) intersect(ray, primitive_ids + node.link, node.count);
///         i = is_met || node.is_leaf() ? i + 1 : node.link;
///     }
struct SkipLayout {
    LayoutArray<SkipNode> nodes;               ///< The root is the first; empty for an empty tree.
    LayoutArray<std::uint32_t> primitive_ids;  ///< Leaf after leaf, in the order of the nodes, without gaps.
    std::uint32_t depth = 0;                   ///< Edges on the longest path from the root to a leaf.
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
CLBVH_API void make_layout(const Bvh& bvh, SkipLayout& result, const LayoutOptions& options = {});

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
CLBVH_API void refit(SkipLayout& layout, const Primitives& primitives, const LayoutOptions& options = {});

/// Proves that the layout is a tree over the primitives: links and ranges as documented, every active primitive in one
/// leaf (or, with split references, covered by its leaves), inactive ones in none, and every box around all that is
/// below. Throws Error(invalid_input) naming the first offender. Never reads out of range. O(n) time and memory, and
/// for split references that of clbvh::validate.
CLBVH_API void validate(const SkipLayout& layout, const Primitives& primitives);

}  // namespace clbvh
