#pragma once

#include <string_view>

#include "clbvh/options.hpp"
#include "device/api/caller_memory.hpp"
#include "device/opencl/device_mesh.hpp"

namespace clbvh::device {

/// The caller's primitives, looked at.
struct CallerInput {
    DeviceMesh mesh;
    CallerMemory vertices;  ///< or boxes; where there are indices, the first vertex alone: the others may be anywhere
    CallerMemory indices;   ///< empty where there are none
};

/// Throws Error(invalid_input) that names what is wrong with `input`: everything but its values is checked.
[[nodiscard]] CallerInput check_input(const Session& session, const DeviceInput& input);

[[nodiscard]] std::uint32_t count_of(const DeviceInput& input);

/// Throws Error(unsupported) where `options` ask for work of the host around the build; `who` leaves it out.
void check_device_options(std::string_view who, const BuildOptions& options);

}  // namespace clbvh::device
