#pragma once

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"

namespace clbvh::optimizer {

/// Throws Error(invalid_input) unless the mesh's active triangles are those of the tree, and what check_mesh throws.
void check_same_triangles(const Bvh& tree, const Mesh& mesh);

}  // namespace clbvh::optimizer
