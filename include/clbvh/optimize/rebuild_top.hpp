#pragma once

#include <cstdint>

#include "clbvh/core/bvh.hpp"
#include "clbvh/export.h"
#include "clbvh/optimize/budget.hpp"

namespace clbvh {

/// Builds the top of a tree anew, by binned SAH over the boxes of what is below it, and keeps the cheaper top. Where
/// that is the old one, the next passes do the same to parts of it, from the top down.
///
/// Binned SAH over clusters that were found by other means is the upper part of HLBVH (Pantaleoni, Luebke 2010, "HLBVH:
/// Hierarchical LBVH Construction for Real-Time Ray Tracing of Dynamic Geometry"; Garanzha, Pantaleoni, McAllister
/// 2011, "Simpler and Faster HLBVH with Work Queues"). There it is the only top, and begins at some level of the Morton
/// codes; here it has to be cheaper, and consists of the nodes with the largest boxes, on which the cost depends most.
struct RebuildTopConfig {
    /// Part of the inner nodes that belongs to the top, 0 to 1, by samples, and thus not exactly. In small trees it is
    /// about a thousand nodes in any case.
    float share = 1.0f / 32;
    OptimizeBudget budget;  ///< 3 passes unless it says otherwise.
};

/// Works in the calling task arena of oneTBB; the tree is the same on any number of threads. It takes every tree that
/// validate() accepts; leaves stay as they are, and the SAH cost never rises. Throws Error(invalid_input) where a field
/// of `config` is out of its range, naming it; Error(out_of_memory).
[[nodiscard]] CLBVH_API Bvh rebuild_top(Bvh tree, const RebuildTopConfig& config = {}, OptimizeStats* stats = nullptr);

}  // namespace clbvh
