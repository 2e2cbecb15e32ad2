#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clbvh/core/mesh.hpp"
#include "clbvh/core/ray.hpp"

namespace clbvh::test {

/// Triangles that share vertices; some are inactive.
[[nodiscard]] Mesh mesh_with_inactive();

/// Rays to some of the mesh's vertices from a point outside its box.
[[nodiscard]] std::vector<Ray> rays_to_vertices(const Aabb& box, const Mesh& mesh);

/// A mesh in arrays that lie otherwise, with numbers between the elements that must not be read.
struct ViewedMesh {
    std::string name;
    std::vector<float> vertices;
    std::vector<std::uint16_t> short_indices;
    std::vector<std::uint32_t> indices;
    MeshView view;  ///< Of the arrays above, which keep their memory where the object is moved.
};

/// The mesh in every kind of layout: strides of 12, 16, 20 and 24 bytes with an offset, indices of 32 and 16 bits (the
/// latter where there are few vertices enough), tight and with a stride, and no indices.
[[nodiscard]] std::vector<ViewedMesh> layouts_of(const Mesh& mesh);

/// Boxes in an array that lies otherwise.
struct ViewedBoxes {
    std::string name;
    std::vector<float> floats;
    BoxView view;
};

/// The boxes with strides of 24, 28 and 32 bytes.
[[nodiscard]] std::vector<ViewedBoxes> layouts_of(const std::vector<Aabb>& boxes);

}  // namespace clbvh::test
