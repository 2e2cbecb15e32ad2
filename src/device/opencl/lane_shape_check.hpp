#pragma once

#include "device/opencl/session.hpp"

namespace clbvh::device {

[[nodiscard]] ProgramSpec lane_shape_check_program();

/// Runs kernels/core/lane_shape_check.cl and compares with the host. False where the result is wrong or the driver
/// refuses.
[[nodiscard]] bool lane_shape_passes_check(Session& session);

}  // namespace clbvh::device
