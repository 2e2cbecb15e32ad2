#pragma once

#include "device/build/build_buffers.hpp"
#include "device/opencl/launcher.hpp"

namespace clbvh::device {

/// The kernels of this stage.
[[nodiscard]] ProgramSpec leaves_program(const BuildSettings& settings);

/// Boxes of the first `leaf_count` sorted primitives into buffers.leaves. One launch.
void launch_leaves(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& buffers,
                   std::uint32_t leaf_count);

/// Cluster i is leaf i: 0 .. leaf_count - 1 into buffers.references_a. One launch.
void launch_number_leaves(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& buffers,
                          std::uint32_t leaf_count);

}  // namespace clbvh::device
