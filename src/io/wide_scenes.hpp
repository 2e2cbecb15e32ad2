#pragma once

#include <cstdint>

#include "clbvh/core/mesh.hpp"

/// Generated scenes whose parts are of very different size, or very far from each other. All have exactly `count`
/// triangles.
namespace clbvh::io {

/// Small triangles in a unit cube, and one more whose three coordinates are `distance`.
[[nodiscard]] Mesh make_outlier(std::uint64_t count, std::uint64_t seed, double distance);

/// Small triangles in a unit cube, between planes a thousand times as large: a ground and two walls.
[[nodiscard]] Mesh make_planes(std::uint64_t count, std::uint64_t seed);

/// Small triangles in a unit cube, in a sphere of radius 1000 of a sixteenth as many.
[[nodiscard]] Mesh make_sky(std::uint64_t count, std::uint64_t seed);

/// Two unit cubes of small triangles, `distance` from each other along x.
[[nodiscard]] Mesh make_two_objects(std::uint64_t count, std::uint64_t seed, double distance);

/// A globe in metres around the origin, a quarter of the triangles, and a town of two kilometres on it; coordinates
/// have steps of half a metre there.
[[nodiscard]] Mesh make_planet(std::uint64_t count, std::uint64_t seed);

/// Cubes of small triangles about the same corner, as many triangles in each, of edges 1, 0.1, ... 10^-orders.
[[nodiscard]] Mesh make_mixed(std::uint64_t count, std::uint64_t seed, double orders);

/// A ball with bumps of all sizes, of nearly equal triangles, as scans are.
[[nodiscard]] Mesh make_scanlike(std::uint64_t count, std::uint64_t seed);

}  // namespace clbvh::io
