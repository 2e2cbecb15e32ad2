#pragma once

#include <cstdint>

#include "clbvh/core/ray.hpp"
#include "clbvh/device/shape.hpp"

namespace clbvh {

/// How a DeviceTracer traces. None of it changes a hit but the triangle test.
struct DeviceTracerOptions {
    TriangleTest triangle_test = TriangleTest::watertight;
    /// group: a work item for each ray. lane: work groups of one item, which takes a block of rays. automatic: lane on
    /// CPUs that pass the self-test.
    Shape shape = Shape::automatic;
    std::uint32_t work_group_size = 0;  ///< Of the group shape, 2 to 1024; 0: 64.
    std::uint32_t block_rays = 0;       ///< Rays for a work group, up to 65536; 0: 64 (lane), or one an item (group).
    std::uint32_t stack_entries = 0;    ///< Of a ray's private stack, 1 to 1024; 0: 48. Rays that need more cost more.
};

}  // namespace clbvh
