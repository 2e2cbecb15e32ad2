#include "trace/leaf_triangles.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace clbvh::trace {

std::vector<LeafTriangle> copy_triangles(const Bvh& bvh, const Mesh& mesh) {
    std::vector<LeafTriangle> triangles(bvh.primitive_ids.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, triangles.size(), 4096), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const std::uint32_t primitive = bvh.primitive_ids[i];
            const Triangle& t = mesh.triangles[primitive];
            triangles[i] = {{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}, primitive};
        }
    });
    return triangles;
}

}  // namespace clbvh::trace
