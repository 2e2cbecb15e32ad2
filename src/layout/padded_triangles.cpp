#include "clbvh/layout/padded_triangles.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <tuple>

#include "core/arena_size.hpp"
#include "core/check_field.hpp"
#include "core/memory_errors.hpp"
#include "core/own_group.hpp"
#include "core/primitive_access.hpp"

namespace clbvh {
namespace {

template <typename Triangles>
void write(const Triangles& triangles, PaddedTriangle* result) {
    const auto padded = [](const float* v) { return std::array<float, 4>{v[0], v[1], v[2], 0.0f}; };
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, triangles.count, 4096), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            for (std::size_t corner = 0; corner < 3; ++corner)
                result[i].vertices[corner] = padded(triangles.vertex(triangles.index(i, corner)));
        }
    });
}

}  // namespace

void make_padded_triangles(const MeshView& mesh, LayoutArray<PaddedTriangle>& result, const LayoutOptions& options) {
    check_range("thread_count", options.thread_count, 0, 1024);
    result.clear();
    with_memory_errors("the triangles", [&] {
        tbb::task_arena arena(arena_size(options.thread_count));
        execute_in(arena, [&] {
            if (options.check) std::ignore = check_mesh(mesh);
            result.resize_for_overwrite(mesh.triangle_count);
            with_triangles(mesh, [&](const auto& triangles) { write(triangles, result.data()); });
        });
    });
}

}  // namespace clbvh
