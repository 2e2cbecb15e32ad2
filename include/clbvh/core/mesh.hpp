#pragma once

#include <vector>

#include "clbvh/core/aabb.hpp"
#include "clbvh/core/primitives.hpp"

namespace clbvh {

/// An indexed triangle mesh that owns its arrays. Primitive i is triangles[i].
struct Mesh {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;

    /// A view of it, for free. It is valid until a vector changes its size.
    // NOLINTNEXTLINE(google-explicit-constructor): whatever takes a view takes a mesh
    [[nodiscard]] operator MeshView() const noexcept {
        return {reinterpret_cast<const float*>(vertices.data()), vertices.size(), sizeof(Vec3), triangles.data(),
                triangles.size()};
    }
};
static_assert(sizeof(Vec3) == 3 * sizeof(float) && sizeof(Triangle) == 3 * sizeof(std::uint32_t));

}  // namespace clbvh
