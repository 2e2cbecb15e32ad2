#pragma once

#include "device/build_buffers.hpp"
#include "device/launcher.hpp"

namespace clbvh::device {

/// Sorts the pairs that launch_morton left: buffers.primitive_ids and buffers.codes in ascending order, ties by
/// primitive. 24 launches in the group shape, 16 in the lane shape.
void launch_radix_sort(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& buffers,
                       std::uint32_t primitive_count);

}  // namespace clbvh::device
