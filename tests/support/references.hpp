#pragma once

#include <span>
#include <vector>

#include "clbvh/core/mesh.hpp"
#include "host/build/reference.hpp"

namespace clbvh::test {

/// A reference for each triangle of a mesh without inactive ones.
[[nodiscard]] std::vector<host::Reference> references_of(const Mesh& mesh);

/// The boxes alone.
[[nodiscard]] std::vector<Aabb> boxes_of(const Mesh& mesh);

/// The box around the doubled centroids, which is what centroids are binned within.
[[nodiscard]] Box4 centroid_bounds_of(std::span<const host::Reference> references);

}  // namespace clbvh::test
