#pragma once

#include <clbvh/device/device.hpp>
#include <nlohmann/json.hpp>
#include <span>

#include "build_result.hpp"

namespace clbvh::tool {

[[nodiscard]] nlohmann::ordered_json to_json(const DeviceInfo& device);

/// The document of `build` and `bench`: the device and one entry per result.
[[nodiscard]] nlohmann::ordered_json to_json(const DeviceInfo& device, std::span<const BuildResult> results);

}  // namespace clbvh::tool
