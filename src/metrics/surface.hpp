#pragma once

#include <array>
#include <cstdint>

#include "clbvh/core/mesh.hpp"

namespace clbvh {

/// A triangle as a piece of surface, in double precision.
class Surface {
public:
    using Point = std::array<double, 3>;

    Surface(const Mesh& mesh, std::uint32_t triangle) noexcept;

    [[nodiscard]] const Aabb& bounds() const noexcept { return bounds_; }
    [[nodiscard]] double area() const noexcept { return area_; }
    /// The area of the part within `box`, which includes its faces: a triangle that lies in a face is within.
    [[nodiscard]] double area_within(const Aabb& box) const noexcept;
    /// The point at (1 - u - v) * corner 0 + u * corner 1 + v * corner 2.
    [[nodiscard]] Point at(double u, double v) const noexcept;

private:
    std::array<Point, 3> corners_;
    Aabb bounds_;
    double area_;
};

/// True where the boxes have a point in common.
[[nodiscard]] constexpr bool touch(const Aabb& a, const Aabb& b) noexcept {
    return a.lower.x <= b.upper.x && b.lower.x <= a.upper.x && a.lower.y <= b.upper.y && b.lower.y <= a.upper.y &&
           a.lower.z <= b.upper.z && b.lower.z <= a.upper.z;
}

/// True where `inner` has no point that `outer` has not.
[[nodiscard]] constexpr bool is_within(const Aabb& inner, const Aabb& outer) noexcept {
    return merge(inner, outer) == outer;
}

}  // namespace clbvh
