#pragma once

#include <tbb/task_arena.h>

#include <string>
#include <variant>

#include "clbvh/core/error.hpp"
#include "clbvh/core/primitives.hpp"
#include "clbvh/layout/make_layout.hpp"
#include "core/arena_size.hpp"
#include "core/check_field.hpp"
#include "core/memory_errors.hpp"
#include "core/own_group.hpp"
#include "core/primitive_access.hpp"

// What the refit of any layout has around it.
namespace clbvh::layout {

/// Runs `work`, which refits `layout`, with the threads that `options` ask for, once the primitives are proven to be as
/// many as were laid out, and, unless the options trust them, to be as check_primitives wants them.
/// Throws Error(invalid_input), before `work` runs, and Error(out_of_memory).
template <typename Layout, typename Work>
void refit_in_arena(const Layout& layout, const Primitives& primitives, const LayoutOptions& options,
                    const Work& work) {
    check_range("thread_count", options.thread_count, 0, 1024);
    if (count_of(primitives) != layout.primitive_count) {
        const bool is_mesh = std::holds_alternative<MeshView>(primitives);
        throw Error(ErrorCode::invalid_input, "the layout is over " + std::to_string(layout.primitive_count) +
                                                  (is_mesh ? " triangles, but " : " boxes, but ") +
                                                  count_in_words(primitives) +
                                                  "; give those that it was made over, moved");
    }
    with_memory_errors("refitting", [&] {
        tbb::task_arena arena(arena_size(options.thread_count));
        execute_in(arena, [&] {
            if (options.check) static_cast<void>(check_primitives(primitives));
            work();
        });
    });
}

}  // namespace clbvh::layout
