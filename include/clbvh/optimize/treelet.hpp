#pragma once

#include <cstdint>

#include "clbvh/core/bvh.hpp"
#include "clbvh/export.h"
#include "clbvh/optimize/budget.hpp"

namespace clbvh {

/// Restructures treelets: of the nodes below each inner node, those that are largest make a small tree of at most
/// `leaves` leaves, which is replaced by the best of all binary trees over them, found by dynamic programming.
///
/// Karras, Aila 2013, "Fast Parallel Construction of High-Quality Bounding Volume Hierarchies", section 3. Leaves of
/// the tree stay as they are: merging them is collapse()'s work, where the paper decides on both at once.
struct TreeletConfig {
    std::uint32_t leaves = 7;  ///< Leaves of a treelet, 3 to 8.
    /// Leaves that a node must have below it to be the root of a treelet in the first pass; each pass doubles it. Any
    /// number: below 3 it is 3, and above the number of leaves nothing is changed.
    std::uint32_t least_size = 7;
    OptimizeBudget budget;  ///< 3 passes unless it says otherwise.
};

/// Works in the calling task arena of oneTBB; the tree is the same on any number of threads. It takes every tree that
/// validate() accepts; the SAH cost never rises. Throws Error(invalid_input) where a field of `config` is out of its
/// range, naming it; Error(out_of_memory).
[[nodiscard]] CLBVH_API Bvh restructure_treelets(Bvh tree, const TreeletConfig& config = {},
                                                 OptimizeStats* stats = nullptr);

}  // namespace clbvh
