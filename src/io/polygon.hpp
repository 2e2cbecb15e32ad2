#pragma once

#include <cstdint>
#include <span>

#include "clbvh/core/mesh.hpp"

namespace clbvh::io {

/// Most corners of a concave polygon that is clipped ear by ear, which takes quadratic time.
inline constexpr std::size_t kMaxClippedCorners = 1000;

/// Appends a polygon of three or more `corners`, indices of mesh.vertices in range, as exactly corners - 2 triangles of
/// the same winding. A convex polygon becomes a fan around its first corner, a concave one is clipped ear by ear in the
/// plane that it faces most; what is neither (self-intersecting, NaN, very many corners) becomes a fan too.
void append_polygon(std::span<const std::uint32_t> corners, Mesh& mesh);

}  // namespace clbvh::io
