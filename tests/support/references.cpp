#include "support/references.hpp"

#include "host/build/primitive_bounds.hpp"

namespace clbvh::test {

std::vector<host::Reference> references_of(const Mesh& mesh) {
    std::vector<host::Reference> references(mesh.triangles.size());
    Scratch scratch;
    host::bound_primitives(boxes_of(mesh), references, scratch);
    return references;
}

std::vector<Aabb> boxes_of(const Mesh& mesh) {
    std::vector<Aabb> boxes;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        boxes.push_back(triangle_bounds(mesh, i));
    return boxes;
}

Box4 centroid_bounds_of(std::span<const host::Reference> references) {
    Box4 bounds;
    for (const host::Reference& reference : references)
        bounds.merge(Box4::of(reference).doubled_centroid());
    return bounds;
}

}  // namespace clbvh::test
