#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "clbvh/core/mesh.hpp"
#include "clbvh/core/ray.hpp"

namespace clbvh::test {

/// True for a ray that hits nothing whatever the scene is.
[[nodiscard]] bool hits_nothing(const Ray& ray);

/// Where the ray, from its beginning to its end, is in the box, with some slack at the end; or nothing. A slab that a
/// comparison with NaN concerns is left out.
[[nodiscard]] std::optional<float> entry_of_box(const Aabb& box, const Ray& ray);

/// The hit of the ray, which may hit something, with one triangle of the mesh, if there is one.
[[nodiscard]] std::optional<Hit> hit_of_triangle(const Mesh& mesh, std::uint32_t triangle, const Ray& ray,
                                                 TriangleTest test = TriangleTest::watertight);

/// Every hit of the ray with any triangle of the mesh, found without a tree, ordered by t, then by primitive.
[[nodiscard]] std::vector<Hit> brute_force_all(const Mesh& mesh, const Ray& ray,
                                               TriangleTest test = TriangleTest::watertight);

/// The first of these hits, or a miss.
[[nodiscard]] Hit brute_force_closest(const Mesh& mesh, const Ray& ray, TriangleTest test = TriangleTest::watertight);

/// True where both hits are the same bytes.
[[nodiscard]] bool same_bits(const Hit& a, const Hit& b);

/// Rays of many kinds for a mesh, `count` of each: between points of its box and around it; along the axes, with zeros
/// and negative zeros, also from coordinates of vertices, so that they run in faces of boxes; through vertices and
/// points of edges; along edges; from points on triangles; short ones, and ones that start late.
[[nodiscard]] std::vector<Ray> difficult_rays(const Mesh& mesh, std::size_t count, std::uint64_t seed = 1);

/// Rays that hit nothing by definition.
[[nodiscard]] std::vector<Ray> untraceable_rays();

}  // namespace clbvh::test
