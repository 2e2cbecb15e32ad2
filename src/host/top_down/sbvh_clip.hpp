#pragma once

#include <array>
#include <cstdint>

#include "clbvh/core/primitives.hpp"
#include "host/build/reference.hpp"

namespace clbvh::host {

/// A triangle that is cut by planes across an axis.
class CutTriangle {
public:
    CutTriangle(const MeshView& mesh, std::uint32_t triangle) noexcept;

    [[nodiscard]] Float4 corner(std::size_t i) const noexcept { return corners_[i]; }

    [[nodiscard]] float coordinate(std::size_t i, std::size_t axis) const noexcept { return coordinates_[i][axis]; }

    /// A box around the part of the triangle between two planes, grown so that rounding takes nothing from it.
    [[nodiscard]] Box4 bound_between(std::size_t axis, float lower, float upper) const noexcept;

private:
    /// The box of cross(), grown by more than its error.
    [[nodiscard]] Box4 bound_crossing(std::size_t from, std::size_t to, std::size_t axis, float plane) const noexcept;

    std::array<Float4, 3> corners_;
    std::array<std::array<float, 4>, 3> coordinates_;
};

/// An edge of a triangle that is cut by several planes across an axis.
class CutEdge {
public:
    CutEdge(const CutTriangle& triangle, std::size_t from, std::size_t to, std::size_t axis) noexcept
        : origin_(triangle.corner(from)),
          direction_(triangle.corner(to) - triangle.corner(from)),
          start_(triangle.coordinate(from, axis)),
          scale_(1.0f / (triangle.coordinate(to, axis) - start_)) {}

    /// Where the edge meets a plane that its ends are on both sides of, about as floats round.
    [[nodiscard]] Float4 cross(float plane) const noexcept {
        return origin_ + Float4::filled((plane - start_) * scale_) * direction_;
    }

private:
    Float4 origin_;
    Float4 direction_;
    float start_;
    float scale_;
};

/// True where the box has a point: nowhere lower above upper.
[[nodiscard]] inline bool has_point(const Box4& box) noexcept {
    return all_at_most(box.lower, box.upper);
}

/// The box that both share.
[[nodiscard]] inline Box4 intersect(const Box4& a, const Box4& b) noexcept {
    return {max(a.lower, b.lower), min(a.upper, b.upper)};
}

/// `box` with [lower, upper] along one axis.
[[nodiscard]] Box4 with_range(const Box4& box, std::size_t axis, float lower, float upper) noexcept;

/// The parts of a reference on both sides of a plane. A part without a point is nothing.
struct CutReference {
    Box4 left;
    Box4 right;
};

/// Together the parts cover what the reference covers of its triangle, or, without a mesh, of its box.
[[nodiscard]] CutReference cut_reference(const MeshView* mesh, const Reference& reference, std::size_t axis,
                                         float plane) noexcept;

}  // namespace clbvh::host
