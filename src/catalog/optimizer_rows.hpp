#pragma once

#include <string_view>
#include <vector>

#include "clbvh/catalog.hpp"
#include "clbvh/core/bvh.hpp"
#include "clbvh/optimize/budget.hpp"

namespace clbvh {

namespace device {
struct DeviceOptimizerRow;
}

/// The ids of a list with commas between them; none where it is empty.
[[nodiscard]] std::vector<std::string_view> optimizer_ids(std::string_view list);

/// Runs the optimiser `id` within a build, where triangles have been split before if it asks for that.
[[nodiscard]] Bvh run_optimizer(Bvh tree, std::string_view id, const OptimizeBudget& budget,
                                OptimizeStats* stats = nullptr);

/// The options with a quota of splits where one of their optimizers asks for it and they have none. Throws what
/// check_optimizers throws, and Error(invalid_input) where triangles would be split by presplit_level instead.
[[nodiscard]] BuildOptions with_split_of_optimizers(BuildOptions options);

/// The device form of the optimiser `id`; null where it runs on the host only. Throws what find_optimizer
/// throws.
[[nodiscard]] const device::DeviceOptimizerRow* find_device_row(std::string_view id);

/// Throws what check_optimizers throws, and Error(unsupported) naming the first of `ids`, ids with commas between them,
/// that runs on the host only.
void check_device_optimizers(std::string_view ids);

}  // namespace clbvh
