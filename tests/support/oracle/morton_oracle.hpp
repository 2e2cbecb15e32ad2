#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clbvh/core/mesh.hpp"
#include "clbvh/options.hpp"

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

/// What a device sorts `count` primitives by instead of their codes: of each active one the leading bits of its code,
/// as many as `code_bits` says or as fit, above its id. No active primitive has all of these bits set.
[[nodiscard]] std::vector<std::uint64_t> packed_keys(std::span<const std::uint64_t> codes,
                                                     std::span<const std::uint32_t> ids, std::uint64_t count,
                                                     std::uint32_t code_bits);

/// Active primitives sorted by key, equal keys by id. A place in this order is a Morton position.
struct MortonOrder {
    std::vector<std::uint64_t> codes;  ///< The keys: packed ones, or codes of 63 bits.
    std::vector<std::uint32_t> ids;
    std::vector<Aabb> bounds;
    std::uint64_t primitive_count = 0;  ///< Inactive ones included.
};

/// `code_bits` as in DeviceConfig.
[[nodiscard]] MortonOrder morton_order(const Mesh& mesh, MortonCode code, std::uint32_t code_bits = 44);
/// The order that device builders with these options documentedly sort by.
[[nodiscard]] MortonOrder morton_order(const Mesh& mesh, const BuildOptions& options);

}  // namespace clbvh::test
