#pragma once

#include <cstdint>
#include <string>

#include "device/opencl/session.hpp"

namespace clbvh::device {

/// Launches of hand_over_check.cl that make ten million hand-overs in groups of 256.
inline constexpr std::uint32_t kHandOverLaunches = 17;

/// Runs kernels/core/hand_over_check.cl, compiled with `options` more. False where a word did not arrive, or the driver
/// refuses.
[[nodiscard]] bool hand_over_passes_check(Session& session, std::uint32_t launches = kHandOverLaunches,
                                          const std::string& options = {});

}  // namespace clbvh::device
