#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "clbvh/core/aabb.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// Three indices into Mesh::vertices.
using Triangle = std::array<std::uint32_t, 3>;

/// An indexed triangle mesh. Primitive i is triangles[i].
struct Mesh {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
};

/// Largest magnitude of a coordinate. Beyond it half areas, or the distances of the builders, would overflow float32.
/// Products of an area and a cost may overflow a little before it: AAC then makes leaves of subtrees that cost less.
inline constexpr float kMaxCoordinate = 1e18f;

/// Most primitives of one build: node indices stay below 2^31.
inline constexpr std::uint64_t kMaxPrimitives = (std::uint64_t{1} << 30) - 1;

/// The box of one triangle. Not meaningful for an inactive triangle.
[[nodiscard]] inline Aabb triangle_bounds(const Mesh& mesh, std::size_t triangle) {
    const Triangle& t = mesh.triangles[triangle];
    Aabb box{mesh.vertices[t[0]], mesh.vertices[t[0]]};
    box = merge(box, mesh.vertices[t[1]]);
    return merge(box, mesh.vertices[t[2]]);
}

/// True where a coordinate of the triangle is NaN: such a primitive is left out of every tree and never hit.
[[nodiscard]] CLBVH_API bool is_inactive(const Mesh& mesh, std::size_t triangle);

/// Checks the contract that every builder relies on, in parallel, and counts the inactive primitives.
/// Throws Error(invalid_input) naming the first triangle with an index out of range or a coordinate that is infinite or
/// beyond kMaxCoordinate, and Error(unsupported) where there are more than kMaxPrimitives triangles.
[[nodiscard]] CLBVH_API std::uint64_t check_mesh(const Mesh& mesh);

}  // namespace clbvh
