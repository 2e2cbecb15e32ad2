#pragma once

#include "device/opencl/session.hpp"

namespace clbvh::device {

[[nodiscard]] ProgramSpec lane_self_test_program();

/// Runs kernels/core/lane_self_test.cl and compares with the host. False where the result is wrong or the driver
/// refuses.
[[nodiscard]] bool lane_shape_passes_self_test(Session& session);

}  // namespace clbvh::device
