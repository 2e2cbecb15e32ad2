#pragma once

#include <clbvh/core/aabb.hpp>
#include <clbvh/core/vector.hpp>

// Arithmetic of colours: linear red, green and blue in x, y and z.
namespace clbvh::tool {

/// How bright a colour looks (Rec. 709).
[[nodiscard]] constexpr float brightness(const Vec3& colour) noexcept {
    return dot(colour, {0.2126f, 0.7152f, 0.0722f});
}

/// Light of the one colour after a surface or a glass of the other.
[[nodiscard]] constexpr Vec3 modulated(const Vec3& a, const Vec3& b) noexcept {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}

/// The colour that `modulated` with `b` turns into `a`; `b` has no zeros.
[[nodiscard]] constexpr Vec3 demodulated(const Vec3& a, const Vec3& b) noexcept {
    return {a.x / b.x, a.y / b.y, a.z / b.z};
}

}  // namespace clbvh::tool
