#pragma once

#include "device/build/build_buffers.hpp"
#include "device/opencl/launcher.hpp"

namespace clbvh::device {

/// The kernels of this stage.
[[nodiscard]] ProgramSpec root_program(const BuildSettings& settings);

/// The root into buffers.nodes, whose sibling pairs stand already. One launch.
void launch_root(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& buffers, BoxOrder box_order);

/// Zeros into those of the first 2 * primitive_count nodes that are behind the leaf_count leaves' own. One launch.
void launch_clear_unused(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& buffers);

}  // namespace clbvh::device
