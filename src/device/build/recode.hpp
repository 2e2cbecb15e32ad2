#pragma once

#include "device/build/build_buffers.hpp"
#include "device/opencl/launcher.hpp"

namespace clbvh::device {

/// The kernels of this step.
[[nodiscard]] ProgramSpec recode_program(const BuildSettings& settings);

/// Behind the sort of `primitive_count` packed keys: runs of equal codes get codes within their own bounds, and are
/// sorted by these. buffers.codes stay sorted and all different; keys is scratch.
void launch_recode(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& buffers,
                   std::uint32_t primitive_count);

}  // namespace clbvh::device
