#pragma once

#include <array>
#include <cstdint>

#include "clbvh/core/primitives.hpp"
#include "core/polygon_cut.hpp"

namespace clbvh {

/// A triangle as a piece of surface, in double precision.
class TriangleSurface {
public:
    TriangleSurface(const MeshView& mesh, std::uint32_t triangle) noexcept;

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

}  // namespace clbvh
