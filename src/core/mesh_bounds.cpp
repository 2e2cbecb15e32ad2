#include "clbvh/core/mesh_bounds.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <cstddef>

namespace clbvh {

Aabb mesh_bounds(const Mesh& mesh) {
    constexpr std::size_t grain = 4096;
    return tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, mesh.triangles.size(), grain), Aabb{},
        [&](const auto& range, Aabb box) {
            for (std::size_t i = range.begin(); i < range.end(); ++i) {
                if (!is_inactive(mesh, i)) box = merge(box, triangle_bounds(mesh, i));
            }
            return box;
        },
        [](const Aabb& a, const Aabb& b) { return merge(a, b); });
}

}  // namespace clbvh
