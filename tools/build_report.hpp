#pragma once

#include <clbvh/device/device.hpp>
#include <string>

#include "build_result.hpp"

namespace clbvh::tool {

/// What `build` tells people: a line for each thing worth knowing, and the table of stages.
[[nodiscard]] std::string build_report(const DeviceInfo& device, const BuildResult& result, double load_ms);

}  // namespace clbvh::tool
