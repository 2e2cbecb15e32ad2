#pragma once

#include "clbvh/core/aabb.hpp"
#include "clbvh/core/mesh.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// The box of all triangles that are not inactive; empty where there are none. The mesh is as check_mesh wants it.
[[nodiscard]] CLBVH_API Aabb mesh_bounds(const MeshView& mesh);

}  // namespace clbvh
