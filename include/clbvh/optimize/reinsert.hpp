#pragma once

#include <cstdint>

#include "clbvh/core/bvh.hpp"
#include "clbvh/export.h"
#include "clbvh/optimize/budget.hpp"

namespace clbvh {

/// Takes subtrees out of a tree and puts them where they cost least, found by branch and bound over the whole tree.
///
/// Meister, Bittner 2018, "Parallel Reinsertion for Bounding Volume Hierarchy Optimization": the best places of many
/// nodes are searched at once, then the moves are made one after the other, the most gainful first. A move that others
/// have made worthless in the meantime is not made, so that the SAH cost never rises.
struct ReinsertConfig {
    /// Most nodes that a pass tries to move, as a part of all, above 0 to 1: those where the parent is larger by most.
    float candidates = 0.1f;
    /// Ends when a pass with that many lowers the summed area of the inner nodes by less than this part of it, 0 to 1.
    float least_gain = 0.001f;
    OptimizeBudget budget;  ///< At most 64 passes unless it says otherwise.
};

/// Works in the calling task arena of oneTBB; the tree is the same on any number of threads. It takes every tree that
/// validate() accepts; leaves stay as they are. Throws Error(invalid_input) where a field of `config` is out of its
/// range, naming it; Error(out_of_memory).
[[nodiscard]] CLBVH_API Bvh reinsert(Bvh tree, const ReinsertConfig& config = {}, OptimizeStats* stats = nullptr);

/// Bittner, Hapala, Havran 2013, "Fast Insertion-Based Optimization of Bounding Volume Hierarchies": the sequential
/// form, in which every search sees all moves before it.
struct ReinsertBatchesConfig {
    /// Part of the inner nodes whose children a pass tries to move, above 0 to 1: those of largest combined
    /// inefficiency (section 3.2.1: area, over the mean of the children's, over the least of theirs).
    float batch = 0.01f;
    float least_gain = 0.001f;  ///< As ReinsertConfig::least_gain, over 10 passes together.
    OptimizeBudget budget;      ///< At most 1000 passes unless it says otherwise.
};

/// As reinsert(), on the calling thread.
[[nodiscard]] CLBVH_API Bvh reinsert_batches(Bvh tree, const ReinsertBatchesConfig& config = {},
                                             OptimizeStats* stats = nullptr);

}  // namespace clbvh
