#pragma once

#include <span>

#include "clbvh/core/ray.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// Means over rays of what each ray cost.
struct MeanCounts {
    double inner_nodes = 0.0;
    double leaves = 0.0;
    double triangles = 0.0;

    /// Nodes visited: the steps of a ray through the tree.
    [[nodiscard]] constexpr double steps() const noexcept { return inner_nodes + leaves; }
};

/// All 0 where there are no rays.
[[nodiscard]] CLBVH_API MeanCounts mean_counts(std::span<const RayCounts> rays);

/// The leaf count variability (LCV): the standard deviation of the number of leaves that a ray visits, over these rays
/// (Aila, Karras, Laine 2013, equation 4). Rays that run in lockstep wait for those that visit more leaves. 0 where
/// there are no rays.
[[nodiscard]] CLBVH_API double leaf_count_variability(std::span<const RayCounts> rays);

}  // namespace clbvh
