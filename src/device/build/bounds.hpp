#pragma once

#include "device/build/build_buffers.hpp"
#include "device/opencl/launcher.hpp"

namespace clbvh::device {

/// The kernels of this stage.
[[nodiscard]] ProgramSpec bounds_program(const BuildSettings& settings);

/// Boxes of the mesh's primitives into buffers.boxes, scene and centroid bounds into buffers.bounds. Two launches.
void launch_bounds(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& buffers,
                   const DeviceMesh& mesh);

}  // namespace clbvh::device
