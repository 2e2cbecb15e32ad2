#pragma once

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"
#include "clbvh/metrics/sah.hpp"

namespace clbvh::test {

/// The area of the part of a triangle within a box, computed in the triangle's plane: the corners of the part are among
/// the points where two of the nine lines meet that bound it, three of the triangle and six of the box.
[[nodiscard]] double area_within_oracle(const Mesh& mesh, std::size_t triangle, const Aabb& box);

/// Equation 3 of Aila, Karras, Laine 2013 as it is written: every node against every triangle that is not below it.
[[nodiscard]] double epo_oracle(const Bvh& bvh, const Mesh& mesh, const SahCosts& costs = {});

}  // namespace clbvh::test
