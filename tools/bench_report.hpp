#pragma once

#include <clbvh/device/device.hpp>
#include <cstddef>
#include <span>
#include <string>

#include "build_result.hpp"

namespace clbvh::tool {

/// The table of one scene: what each builder cost, and what its tree is worth. At least one result.
[[nodiscard]] std::string scene_report(const DeviceInfo& device, std::span<const BuildResult> results);

/// Geometric means of each builder over several scenes. `results` holds scene after scene, and for each of them the
/// same `builder_count` builders in the same order.
[[nodiscard]] std::string means_report(std::span<const BuildResult> results, std::size_t builder_count);

}  // namespace clbvh::tool
