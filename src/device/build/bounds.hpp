#pragma once

#include "device/build/build_buffers.hpp"
#include "device/opencl/launcher.hpp"

namespace clbvh::device {

/// The kernels of this stage.
[[nodiscard]] ProgramSpec bounds_program(const DeviceFit& fit);

/// Boxes of the mesh's primitives into buffers.boxes, scene and centroid bounds into buffers.bounds, and the number of
/// active primitives into buffers.primitive_count; of `buffers` only what cut_bounds() cuts is used. Two launches.
void launch_bounds(Launcher& launcher, const DeviceFit& fit, const BuildBuffers& buffers, const DeviceMesh& mesh);

}  // namespace clbvh::device
