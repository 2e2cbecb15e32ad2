#pragma once

#include <string_view>

#include "clbvh/options.hpp"

namespace clbvh {

/// The part of `options`, which are in range, that a device builder reads; the rest has its defaults.
[[nodiscard]] DeviceBuilderConfigs device_configs_for(std::string_view builder_id, const BuildOptions& options);

}  // namespace clbvh
