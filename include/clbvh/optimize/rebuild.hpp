#pragma once

#include <cstdint>

#include "clbvh/core/bvh.hpp"
#include "clbvh/export.h"
#include "clbvh/optimize/budget.hpp"

namespace clbvh {

/// Builds subtrees anew, top-down by the surface area heuristic (build_sweep_sah), and keeps each that is cheaper than
/// what was there. A pass takes the largest subtrees of at most `subtree_leaves` leaves; where that gained much, a
/// second takes the whole tree.
///
/// Clustering bottom-up loses to the greedy top-down tree on evenly tessellated surfaces, and there only (Aila, Karras,
/// Laine 2013, section 5); local changes do not get out of that, so that this goes before reinsertion. Building parts
/// of a tree anew where they are worst is Yoon, Curtis, Manocha 2007, "Ray Tracing Dynamic Scenes using Selective
/// Restructuring".
struct RebuildConfig {
    std::uint32_t subtree_leaves = 1024;  ///< 3 or more.
    /// The whole tree is built anew where the first pass lowered the summed area of the inner nodes by this part of it
    /// or more, 0 to 1.
    float whole_gain = 0.01f;
    OptimizeBudget budget;  ///< 2 passes unless it says otherwise.
};

/// Works in the calling task arena of oneTBB; the tree is the same on any number of threads. It takes every tree that
/// validate() accepts; leaves stay as they are, and the SAH cost never rises. Throws Error(invalid_input) where a field
/// of `config` is out of its range, naming it; Error(out_of_memory).
[[nodiscard]] CLBVH_API Bvh rebuild(Bvh tree, const RebuildConfig& config = {}, OptimizeStats* stats = nullptr);

}  // namespace clbvh
