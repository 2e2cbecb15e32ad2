#include "trace/leaf_triangles.hpp"

namespace clbvh::trace {

std::vector<LeafTriangle> copy_triangles(const Bvh& bvh, const Mesh& mesh) {
    std::vector<LeafTriangle> triangles;
    triangles.reserve(bvh.primitive_ids.size());
    for (const std::uint32_t primitive : bvh.primitive_ids) {
        const Triangle& t = mesh.triangles[primitive];
        triangles.push_back({{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}, primitive});
    }
    return triangles;
}

}  // namespace clbvh::trace
