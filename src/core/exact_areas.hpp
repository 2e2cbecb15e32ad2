#pragma once

#include <array>

#include "clbvh/core/bvh.hpp"
#include "core/simd/box4.hpp"

namespace clbvh {

/// Half the surface area in double precision, so that no rounding makes a change look good: x * y + y * z + z * x over
/// the extents.
[[nodiscard]] constexpr double exact_half_area(const Aabb& box) noexcept {
    const double x = double{box.upper.x} - double{box.lower.x};
    const double y = double{box.upper.y} - double{box.lower.y};
    const double z = double{box.upper.z} - double{box.lower.z};
    return x * y + y * z + z * x;
}
[[nodiscard]] constexpr double exact_half_area(const Node& node) noexcept {
    return exact_half_area(node.bounds());
}

/// Those of two boxes at once, to the bit. What stands in the fourth lanes does not matter.
[[nodiscard]] inline std::array<double, 2> exact_half_areas(const Box4& a, const Box4& b) noexcept {
    const Double2 x = Double2::of_x(a.upper, b.upper) - Double2::of_x(a.lower, b.lower);
    const Double2 y = Double2::of_y(a.upper, b.upper) - Double2::of_y(a.lower, b.lower);
    const Double2 z = Double2::of_z(a.upper, b.upper) - Double2::of_z(a.lower, b.lower);
    std::array<double, 2> areas;
    (x * y + y * z + z * x).store(areas.data());
    return areas;
}

}  // namespace clbvh
