#include "clbvh/core/mesh_bounds.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <cstddef>

#include "core/own_group.hpp"
#include "core/primitive_access.hpp"

namespace clbvh {
namespace {

constexpr std::size_t kGrain = 4096;

}  // namespace

Aabb mesh_bounds(const MeshView& mesh) {
    return with_boxes(mesh, [](const auto& boxes) {
        return in_own_group([&] {
            return tbb::parallel_reduce(
                tbb::blocked_range<std::size_t>(0, boxes.count(), kGrain), Aabb{},
                [&](const auto& range, Aabb box) {
                    for (std::size_t i = range.begin(); i < range.end(); ++i) {
                        if (!boxes.is_inactive(i)) box = merge(box, boxes.box(i));
                    }
                    return box;
                },
                [](const Aabb& a, const Aabb& b) { return merge(a, b); });
        });
    });
}

}  // namespace clbvh
