#pragma once

#include <cstdint>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// Statistics of a tree's shape.
struct TreeStatistics {
    std::uint64_t nodes = 0;       ///< Nodes reached from the root.
    std::uint64_t leaves = 0;      ///< Leaves among them.
    std::uint64_t references = 0;  ///< Primitives of all leaves together; split ones count more than once.
    std::vector<std::uint64_t> leaves_by_depth;  ///< [d]: leaves with d edges between them and the root.
    std::vector<std::uint64_t> leaves_by_size;   ///< [k]: leaves of k primitives; [0] is 0.
    /// The sum over all pairs of siblings of the area of the box that both share, relative to the root's area: of how
    /// many pairs a random line through the root is to be expected to pass through what both cover. Boxes that only
    /// touch share a flat box, which counts; boxes that are apart share none. 0 where the root has no area.
    double sibling_overlap = 0.0;

    /// Edges on the longest path from the root to a leaf; 0 where there is none.
    [[nodiscard]] std::uint32_t depth() const noexcept {
        return leaves_by_depth.empty() ? 0 : static_cast<std::uint32_t>(leaves_by_depth.size() - 1);
    }
    /// The mean over the leaves; 0 where there are none.
    [[nodiscard]] CLBVH_API double mean_leaf_depth() const noexcept;
};

/// Describes a tree in one pass. Boxes are taken as they are. Throws Error(invalid_input) where the nodes form no tree,
/// or a leaf refers beyond the ids, naming the first such node.
[[nodiscard]] CLBVH_API TreeStatistics tree_statistics(const Bvh& bvh);

}  // namespace clbvh
