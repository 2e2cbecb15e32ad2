#pragma once

#include "device/build/build_buffers.hpp"
#include "device/opencl/launcher.hpp"

namespace clbvh::device {

/// The kernels of this stage.
[[nodiscard]] ProgramSpec radix_sort_program(const BuildSettings& settings);

/// Where packed keys are put for launch_radix_sort, so that the last pass leaves them in buffers.codes.
[[nodiscard]] const cl::Buffer& unsorted_keys(const BuildSettings& settings, const BuildBuffers& buffers,
                                              std::uint32_t primitive_count);

/// Counts the first digits of packed keys, for keys that launch_morton did not make. One launch.
void launch_count_keys(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& buffers,
                       std::uint32_t primitive_count);

/// Sorts what launch_morton left: buffers.primitive_ids in Morton order, equal codes by id, and beside them
/// buffers.codes in ascending order: packed keys, or the codes. Three launches a pass of 8 bits in the group shape, of
/// 11 in the lane shape.
void launch_radix_sort(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& buffers,
                       std::uint32_t primitive_count);

}  // namespace clbvh::device
