#pragma once

#include "device/build/build_buffers.hpp"
#include "device/opencl/launcher.hpp"

namespace clbvh::device {

/// The kernels of this stage.
[[nodiscard]] ProgramSpec morton_program(const BuildSettings& settings);

/// Codes of the boxes in buffers.boxes: packed keys into unsorted_keys(), with the counts of their first digits, or
/// pairs_a, code_low and code_high. One launch, or two for extended codes.
void launch_morton(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& buffers,
                   std::uint32_t primitive_count);

}  // namespace clbvh::device
