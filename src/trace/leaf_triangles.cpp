#include "trace/leaf_triangles.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "core/primitive_access.hpp"

namespace clbvh::trace {

std::vector<LeafTriangle> copy_triangles(const Bvh& bvh, const MeshView& mesh) {
    std::vector<LeafTriangle> copies(bvh.primitive_ids.size());
    with_triangles(mesh, [&](const auto& triangles) {
        const TriangleBoxes corners{triangles};
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, copies.size(), 4096), [&](const auto& range) {
            for (std::size_t i = range.begin(); i < range.end(); ++i) {
                const std::uint32_t primitive = bvh.primitive_ids[i];
                copies[i] = {{corners.corner(primitive, 0), corners.corner(primitive, 1), corners.corner(primitive, 2)},
                             primitive};
            }
        });
    });
    return copies;
}

}  // namespace clbvh::trace
