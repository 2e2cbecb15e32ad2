#pragma once

#include "clbvh/catalog.hpp"
#include "host/build/host_build.hpp"

namespace clbvh {

namespace device {
struct DeviceAlgorithm;
}

/// A host builder, with what concerns it of the options of a build.
using HostAlgorithm = void (*)(host::HostBuild& build, const BuildOptions& options);

/// A builder's public row and what is behind it: one of the two, as its kind says.
struct BuilderRow {
    BuilderInfo info;
    const device::DeviceAlgorithm* device_algorithm = nullptr;  ///< Null in builds without OpenCL.
    HostAlgorithm host_algorithm = nullptr;
    bool clips_triangles = false;  ///< The host algorithm reads HostBuild::mesh.
};

/// The row of `id`; throws as find_builder does.
[[nodiscard]] const BuilderRow& find_builder_row(std::string_view id);

}  // namespace clbvh
