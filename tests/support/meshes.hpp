#pragma once

#include <cstddef>
#include <cstdint>

#include "clbvh/core/mesh.hpp"

namespace clbvh::test {

/// `count` small triangles with vertices of their own, spread evenly over a box around the origin.
[[nodiscard]] Mesh random_triangles(std::size_t count, std::uint32_t seed = 1);

/// `count` triangles that all have the same box.
[[nodiscard]] Mesh coincident_triangles(std::size_t count);

/// Sets the y coordinate of one vertex of each `step`-th triangle to NaN, starting with triangle `first`. Meant for
/// meshes whose triangles share no vertices.
void deactivate_triangles(Mesh& mesh, std::size_t first = 0, std::size_t step = 1);

/// The mesh, all coordinates times `factor`.
[[nodiscard]] Mesh scaled(Mesh mesh, float factor);

/// The largest power of two by which the mesh can be scaled and stay legal. Powers of two change no bit of a mantissa.
[[nodiscard]] float largest_scale(const Mesh& mesh);

}  // namespace clbvh::test
