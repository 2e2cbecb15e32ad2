#pragma once

#include <algorithm>
#include <bit>
#include <limits>

// The parentheses around min and max keep macros of these names, as <windows.h> has them, from being expanded.
namespace clbvh {

// Made of bits, since with -ffast-math clang forgets an infinity that a function returns or an operator makes.
inline constexpr float kPositiveInfinity = std::bit_cast<float>(0x7F800000U);
inline constexpr float kNegativeInfinity = std::bit_cast<float>(0xFF800000U);

/// A point or direction in scene units; three packed floats.
struct Vec3 {
    float x = 0.0f;
    float y = 0.0f;
    float z = 0.0f;

    friend constexpr bool operator==(const Vec3&, const Vec3&) = default;
};

[[nodiscard]] constexpr Vec3(min)(const Vec3& a, const Vec3& b) noexcept {
    return {(std::min)(a.x, b.x), (std::min)(a.y, b.y), (std::min)(a.z, b.z)};
}

[[nodiscard]] constexpr Vec3(max)(const Vec3& a, const Vec3& b) noexcept {
    return {(std::max)(a.x, b.x), (std::max)(a.y, b.y), (std::max)(a.z, b.z)};
}

/// Axis-aligned bounding box. Default-constructed empty: merging anything into it gives that thing.
struct Aabb {
    Vec3 lower{kPositiveInfinity, kPositiveInfinity, kPositiveInfinity};
    Vec3 upper{kNegativeInfinity, kNegativeInfinity, kNegativeInfinity};

    friend constexpr bool operator==(const Aabb&, const Aabb&) = default;
};

/// The smallest box around both.
[[nodiscard]] constexpr Aabb merge(const Aabb& a, const Aabb& b) noexcept {
    return {(min)(a.lower, b.lower), (max)(a.upper, b.upper)};
}

/// The smallest box around the box and the point.
[[nodiscard]] constexpr Aabb merge(const Aabb& a, const Vec3& p) noexcept {
    return {(min)(a.lower, p), (max)(a.upper, p)};
}

/// Half the surface area in float32: x * (y + z) + y * z over the extents, in this order of operations.
/// Host and device agree to the bit where contraction into fused multiply-adds is off.
[[nodiscard]] constexpr float half_area(const Aabb& box) noexcept {
    const float x = box.upper.x - box.lower.x;
    const float y = box.upper.y - box.lower.y;
    const float z = box.upper.z - box.lower.z;
    return x * (y + z) + y * z;
}

/// Twice the box's centre, without the division: what Morton codes and centroid bounds are made from.
[[nodiscard]] constexpr Vec3 doubled_centroid(const Aabb& box) noexcept {
    return {box.lower.x + box.upper.x, box.lower.y + box.upper.y, box.lower.z + box.upper.z};
}

}  // namespace clbvh
