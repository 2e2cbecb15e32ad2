#pragma once

#include <clbvh/core/aabb.hpp>

namespace clbvh::tool {

/// Four floats in a register, the fourth without meaning; a vector type of gcc and clang.
using Lanes = float __attribute__((vector_size(16)));

/// A box in registers; one with a lower corner above its upper one is empty.
struct LaneBox {
    Lanes lower;
    Lanes upper;
};

/// The boxes of what lies on the two sides of a plane.
struct SplitBounds {
    LaneBox left;
    LaneBox right;
};

/// Splits the part of the triangle `a`, `b`, `c` inside `box` at the plane where coordinate `axis` (0 to 2) is
/// `position`. Conservative: whatever is rounded, each point of that part lies in one of the two boxes, which are
/// inside `box`. Fast: it is the inner loop of a build that is timed.
[[nodiscard]] SplitBounds split_triangle(const Vec3& a, const Vec3& b, const Vec3& c, const LaneBox& box, unsigned axis,
                                         float position);

}  // namespace clbvh::tool
