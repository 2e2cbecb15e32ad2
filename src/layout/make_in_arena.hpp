#pragma once

#include <tbb/task_arena.h>

#include "clbvh/layout/make_layout.hpp"
#include "core/arena_size.hpp"
#include "core/check_field.hpp"
#include "core/memory_errors.hpp"
#include "core/own_group.hpp"

// What making any layout has around it.
namespace clbvh::layout {

/// Runs `work`, which makes `result` anew; where it throws, `result` is left empty.
template <typename Layout, typename Work>
void make_or_empty(Layout& result, const Work& work) {
    result.clear();
    try {
        work();
    } catch (...) {
        result.clear();
        throw;
    }
}

/// The same with the threads that `options` ask for. Throws Error(invalid_input) and Error(out_of_memory).
template <typename Layout, typename Work>
void make_in_arena(Layout& result, const LayoutOptions& options, const Work& work) {
    check_range("thread_count", options.thread_count, 0, 1024);
    with_memory_errors("the layout", [&] {
        make_or_empty(result, [&] {
            tbb::task_arena arena(arena_size(options.thread_count));
            execute_in(arena, work);
        });
    });
}

}  // namespace clbvh::layout
