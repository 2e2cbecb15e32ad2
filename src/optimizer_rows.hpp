#pragma once

#include <string_view>

#include "clbvh/core/build_options.hpp"
#include "clbvh/core/bvh.hpp"
#include "clbvh/optimize/budget.hpp"

namespace clbvh {

/// Runs the optimiser `id` within a build, where triangles have been split before if it asks for that.
[[nodiscard]] Bvh run_optimizer(Bvh tree, std::string_view id, const OptimizeBudget& budget,
                                OptimizeStats* stats = nullptr);

/// The options with a quota of splits where one of their optimizers asks for it and they have none. Throws what
/// check_optimizers throws, and Error(invalid_input) where triangles would be split by presplit_level instead.
[[nodiscard]] BuildOptions with_split_of_optimizers(BuildOptions options);

}  // namespace clbvh
