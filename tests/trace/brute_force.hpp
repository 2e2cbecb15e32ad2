#pragma once

#include "clbvh/core/mesh.hpp"
#include "clbvh/eval/camera.hpp"

namespace clbvh::test {

/// Tests every triangle in double precision; `mesh` has to outlive the result.
[[nodiscard]] ClosestHits brute_force(const Mesh& mesh);

/// The twelve triangles of a box.
[[nodiscard]] Mesh box_mesh(const Aabb& box);

/// The square of this half width at height 0 of the y axis.
[[nodiscard]] Mesh ground_mesh(float half_width);

}  // namespace clbvh::test
