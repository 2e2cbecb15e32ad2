#pragma once

#include "clbvh/core/aabb.hpp"
#include "clbvh/core/mesh.hpp"

namespace clbvh {

/// The box of all triangles that are not inactive; empty where there are none. The mesh is as check_mesh wants it.
[[nodiscard]] Aabb mesh_bounds(const Mesh& mesh);

}  // namespace clbvh
