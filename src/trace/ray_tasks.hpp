#pragma once

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstddef>

#include "clbvh/trace/tracer.hpp"
#include "core/arena_size.hpp"
#include "core/check_field.hpp"
#include "core/own_group.hpp"

namespace clbvh::trace {

/// Of the calls for many rays. Throws Error(invalid_input).
[[nodiscard]] inline int arena_size_for(const TracerOptions& options) {
    check_range("thread_count", options.thread_count, 0, 1024);
    return arena_size(options.thread_count);
}

/// Rays of one task of the calls for many: enough that those which are under way at a time are many for most of it.
inline constexpr std::size_t kRaysPerPiece = 1024;

/// Calls `action` with the beginnings and ends of pieces of `count` rays, in parallel. Only the last one may be short.
template <typename Action>
void for_each_piece(tbb::task_arena& arena, std::size_t count, const Action& action) {
    execute_in(arena, [&] {
        tbb::parallel_for(std::size_t{0}, (count + kRaysPerPiece - 1) / kRaysPerPiece, [&](std::size_t piece) {
            action(piece * kRaysPerPiece, std::min(count, (piece + 1) * kRaysPerPiece));
        });
    });
}

/// Calls `action` with every index below `count`, in parallel.
template <typename Action>
void for_each_ray(tbb::task_arena& arena, std::size_t count, const Action& action) {
    for_each_piece(arena, count, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            action(i);
    });
}

}  // namespace clbvh::trace
