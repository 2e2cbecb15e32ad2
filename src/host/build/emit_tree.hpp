#pragma once

#include <cstdint>
#include <span>

#include "clbvh/core/bvh.hpp"

namespace clbvh::host {

/// Sizes of the subtree below one inner node.
struct Extent {
    std::uint32_t pairs;       ///< Sibling pairs; 0: the inner node is to be flattened into a leaf.
    std::uint32_t primitives;  ///< Primitive ids of all its leaves.
};

/// Most primitive ids below an inner node that is to be flattened, those counted that stand there more than once.
inline constexpr std::uint32_t kMaxFlattenedIds = 256;

/// A finished tree whose sibling pairs lie in slots of any order, with holes: as a builder writes it.
struct TreeSlots {
    std::span<const Node> nodes;                   ///< The root is 0; pairs begin at even indices from 2.
    std::span<const Extent> extents;               ///< extents[p]: below the parent of the pair in nodes 2p and 2p + 1.
    std::span<const std::uint32_t> primitive_ids;  ///< The leaves' ranges refer to these.
    /// Where given, a leaf's ids are no range but a chain of places: behind `first` comes next_ids[first], and so on.
    std::span<const std::uint32_t> next_ids = {};
};

/// Sizes of the subtree below `node`, an inner node or a leaf.
[[nodiscard]] inline Extent extent_of(const Node& node, std::span<const Extent> extents) noexcept {
    return node.is_leaf() ? Extent{0, node.count} : extents[node.first / 2];
}

/// Writes the tree without holes, depth first, flattening the inner nodes that ask for it; in parallel, and the same on
/// any number of threads. Siblings stay together, a left subtree comes before the right one, and so do primitive ids;
/// in a flattened or chained leaf they ascend, each of them once: its extent counts so. Takes O(n) time and O(log n)
/// stack, at any depth of the tree.
void emit_tree(const TreeSlots& slots, Bvh& result);

}  // namespace clbvh::host
