#pragma once

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"

namespace clbvh::test {

/// Every node with the box of all triangles below it: slow, and sure.
[[nodiscard]] Bvh fitted_by_definition(Bvh tree, const Mesh& mesh);

}  // namespace clbvh::test
