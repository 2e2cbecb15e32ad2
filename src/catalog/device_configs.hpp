#pragma once

#include <string_view>

#include "clbvh/options.hpp"
#include "device/build/build_settings.hpp"

namespace clbvh {

/// The part of `options`, which are in range, that a device builder reads; the rest has its defaults.
[[nodiscard]] device::DeviceConfigs device_configs_for(std::string_view builder_id, const BuildOptions& options);

}  // namespace clbvh
