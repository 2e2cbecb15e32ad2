#pragma once

#include <cmath>

#include "clbvh/core/aabb.hpp"

// Arithmetic of Vec3. In float32, each operation as written: the same on every platform without contraction.
namespace clbvh {

[[nodiscard]] constexpr Vec3 operator+(const Vec3& a, const Vec3& b) noexcept {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
[[nodiscard]] constexpr Vec3 operator-(const Vec3& a, const Vec3& b) noexcept {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
[[nodiscard]] constexpr Vec3 operator-(const Vec3& a) noexcept {
    return {-a.x, -a.y, -a.z};
}
[[nodiscard]] constexpr Vec3 operator*(const Vec3& a, float scale) noexcept {
    return {a.x * scale, a.y * scale, a.z * scale};
}
[[nodiscard]] constexpr Vec3 operator*(float scale, const Vec3& a) noexcept {
    return a * scale;
}

[[nodiscard]] constexpr float dot(const Vec3& a, const Vec3& b) noexcept {
    return (a.x * b.x + a.y * b.y) + a.z * b.z;
}
[[nodiscard]] constexpr Vec3 cross(const Vec3& a, const Vec3& b) noexcept {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
[[nodiscard]] inline float length(const Vec3& a) noexcept {
    return std::sqrt(dot(a, a));
}

/// The same direction with length 1, computed in double precision: no finite vector but zero overflows or vanishes.
/// Zeros become zeros.
[[nodiscard]] inline Vec3 normalized(const Vec3& a) noexcept {
    const double x = a.x;
    const double y = a.y;
    const double z = a.z;
    const double norm = std::sqrt((x * x + y * y) + z * z);
    if (norm == 0.0) return {};
    return {static_cast<float>(x / norm), static_cast<float>(y / norm), static_cast<float>(z / norm)};
}

}  // namespace clbvh
