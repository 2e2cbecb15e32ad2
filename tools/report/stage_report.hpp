#pragma once

#include <span>
#include <string>

#include "measure/build_result.hpp"

namespace clbvh::tool {

/// The stages of the device builders among the results of one scene: their time, the bytes that they moved, and how
/// fast that was beside a copy. What a build takes beside its kernels is a row of its own. Says so where no builder ran
/// on a device.
[[nodiscard]] std::string stage_report(std::span<const BuildResult> results);

}  // namespace clbvh::tool
