#pragma once

#include <array>
#include <vector>

#include "clbvh/core/aabb.hpp"

namespace clbvh::test {

/// What code that was compiled with certain flags made of rays along the axes.
struct AxisRaysFound {
    unsigned rays = 0;
    unsigned wrong = 0;           ///< Rays that missed a box which they go through, or visited one twice.
    unsigned invalid_traced = 0;  ///< Invalid rays that visited a leaf.
    Aabb bounds;                  ///< Of all boxes, merged from an empty one.
};

// One function for each list of flags in tests/CMakeLists.txt.
AxisRaysFound axis_rays_without_flags();
AxisRaysFound axis_rays_fast_math();
AxisRaysFound axis_rays_ofast();
AxisRaysFound axis_rays_finite_math_only();
AxisRaysFound axis_rays_unsafe_math();

}  // namespace clbvh::test
