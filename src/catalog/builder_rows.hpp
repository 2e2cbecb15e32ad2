#pragma once

#include "clbvh/registry.hpp"
#include "host/build/host_build.hpp"

namespace clbvh {

namespace device {
struct DeviceAlgorithm;
}

/// A builder's public row and what is behind it: one of the two, as its kind says.
struct BuilderRow {
    BuilderInfo info;
    const device::DeviceAlgorithm* device_algorithm;  ///< Null in builds without OpenCL.
    host::HostAlgorithm host_algorithm;
    bool clips_triangles = false;  ///< The host algorithm reads HostBuild::mesh.
};

/// The row of `id`; throws as find_builder does.
[[nodiscard]] const BuilderRow& find_builder_row(std::string_view id);

}  // namespace clbvh
