#pragma once

#include <cstdint>

#include "clbvh/core/aabb.hpp"

namespace clbvh {

/// A ray, or a piece of one: the points origin + t * direction with t_min <= t <= t_max. 32 bytes, the same on host and
/// device. The direction need not have length 1; t is in multiples of it.
///
/// A ray with a NaN, with an infinite origin or direction, with a direction of zeros, or with t_min > t_max hits
/// nothing. A t_min below 0 counts as 0; t_max may be infinite.
struct Ray {
    Vec3 origin;
    float t_min = 0.0f;
    Vec3 direction;
    float t_max = kPositiveInfinity;

    friend constexpr bool operator==(const Ray&, const Ray&) = default;
};
static_assert(sizeof(Ray) == 32);

/// Hit::primitive where nothing was hit.
inline constexpr std::uint32_t kNoPrimitive = 0xFFFFFFFFU;

/// Where a ray meets a triangle; 16 bytes, the same on host and device. The point is
/// (1 - u - v) * vertex 0 + u * vertex 1 + v * vertex 2.
struct Hit {
    float t = kPositiveInfinity;
    float u = 0.0f;
    float v = 0.0f;
    std::uint32_t primitive = kNoPrimitive;

    [[nodiscard]] constexpr explicit operator bool() const noexcept { return primitive != kNoPrimitive; }
    friend constexpr bool operator==(const Hit&, const Hit&) = default;
};
static_assert(sizeof(Hit) == 16);

/// Cost of one ray; 16 bytes, the same on host and device.
struct RayCounts {
    std::uint32_t inner_nodes = 0;  ///< Inner nodes visited: each tests the boxes of its two children.
    std::uint32_t leaves = 0;       ///< Leaves visited.
    std::uint32_t triangles = 0;    ///< Triangles, or other primitives, tested.
    std::uint32_t unused = 0;

    friend constexpr bool operator==(const RayCounts&, const RayCounts&) = default;
};
static_assert(sizeof(RayCounts) == 16);

/// How a ray is tested against a triangle.
enum class TriangleTest : std::uint8_t {
    watertight,       ///< Woop, Benthin, Wald 2013: no ray slips between triangles that share an edge or a vertex.
    moller_trumbore,  ///< Moeller, Trumbore 1997: faster; a ray may slip through an edge.
};

}  // namespace clbvh
