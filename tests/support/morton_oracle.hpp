#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clbvh/core/build_options.hpp"
#include "clbvh/core/mesh.hpp"

namespace clbvh::test {

/// The primitives that a tree holds, by ascending id, with their boxes. Coordinates of -0 have become +0.
struct ActivePrimitives {
    std::vector<std::uint32_t> ids;
    std::vector<Aabb> bounds;
};

[[nodiscard]] ActivePrimitives active_primitives(const Mesh& mesh);

/// Smallest boxes around some primitives and around their doubled centroids.
struct SceneBounds {
    Aabb primitives;
    Aabb doubled_centroids;
};

[[nodiscard]] SceneBounds scene_bounds(std::span<const Aabb> bounds);

/// One code per box, put together bit by bit.
[[nodiscard]] std::vector<std::uint64_t> morton_codes(std::span<const Aabb> bounds, MortonCode code);

/// Active primitives sorted by code, equal codes by id. A place in this order is a Morton position.
struct MortonOrder {
    std::vector<std::uint64_t> codes;
    std::vector<std::uint32_t> ids;
    std::vector<Aabb> bounds;
    std::uint64_t primitive_count = 0;  ///< Inactive ones included.
};

[[nodiscard]] MortonOrder morton_order(const Mesh& mesh, MortonCode code);

}  // namespace clbvh::test
