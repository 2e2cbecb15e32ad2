#pragma once

#include <array>

#include "clbvh/core/aabb.hpp"

// Vectors in double precision, in which products of two short edges do not vanish.
namespace clbvh {

using Double3 = std::array<double, 3>;

[[nodiscard]] inline Double3 difference(const Vec3& a, const Vec3& b) noexcept {
    return {static_cast<double>(a.x) - b.x, static_cast<double>(a.y) - b.y, static_cast<double>(a.z) - b.z};
}

[[nodiscard]] inline Double3 cross(const Double3& a, const Double3& b) noexcept {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace clbvh
