#pragma once

#include <cstdint>

#include "clbvh/core/primitives.hpp"
#include "device/opencl/device_mesh.hpp"
#include "device/opencl/session.hpp"

namespace clbvh::device {

/// Primitives of the host, which have passed their check, in buffers that kernels read. On CPU devices these are the
/// caller's own arrays, which must stay as they are for as long as the result is used. Elsewhere each array is copied
/// in one transfer, with what lies between its elements; the copy is complete.
[[nodiscard]] DeviceMesh bind_primitives(Session& session, const Primitives& primitives, std::uint64_t active_count);

}  // namespace clbvh::device
