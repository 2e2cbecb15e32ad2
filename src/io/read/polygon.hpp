#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "clbvh/core/mesh.hpp"

namespace clbvh::io {

/// How a polygon was cut into triangles.
enum class PolygonCut : std::uint8_t {
    clean,  ///< All triangles turn as the polygon does, and so cover no more than its area.
    fan,    ///< Its triangles may overlap, some in a fan: it intersects itself, holds a NaN, or took too much work.
};

/// Appends a polygon of three or more `corners`, indices of mesh.vertices in range, as exactly corners - 2 triangles of
/// the same winding. A convex polygon becomes a fan around its first corner, which is clean; any other is clipped ear
/// by ear in the plane that it faces most. The work is bounded by a multiple of the corners. `tick` is called now and
/// then, and may throw.
PolygonCut append_polygon(
    std::span<const std::uint32_t> corners, Mesh& mesh, const std::function<void()>& tick = [] {});

}  // namespace clbvh::io
