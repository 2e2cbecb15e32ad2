#pragma once

#include <string_view>

#include "clbvh/options.hpp"
#include "device/build/build_settings.hpp"

namespace clbvh {

/// What a device builder reads of `options`, which are in range. What it does not read has its default.
[[nodiscard]] device::DeviceConfigs device_configs_for(std::string_view builder_id, const BuildOptions& options);

}  // namespace clbvh
