#pragma once

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace clbvh {

/// Size of a task arena for an option `thread_count`, of which 0 means all. More threads than oneTBB may start make it
/// print a warning, and change nothing.
[[nodiscard]] inline int arena_size(std::uint32_t thread_count) {
    if (thread_count == 0) return tbb::task_arena::automatic;
    const std::size_t most = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    return static_cast<int>(std::min<std::size_t>(thread_count, most));
}

}  // namespace clbvh
