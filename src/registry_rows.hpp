#pragma once

#include "clbvh/registry.hpp"
#include "device/device_algorithm.hpp"

namespace clbvh {

/// A builder's public row and the function behind it.
struct BuilderRow {
    BuilderInfo info;
    const device::DeviceAlgorithm* device_algorithm;
};

/// The row of `id`; throws as find_builder does.
[[nodiscard]] const BuilderRow& find_builder_row(std::string_view id);

}  // namespace clbvh
