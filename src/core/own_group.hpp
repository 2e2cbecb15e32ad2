#pragma once

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <optional>
#include <type_traits>
#include <utility>

namespace clbvh {

/// Runs `work` in a group of tasks of its own, and returns what it returns. Else tasks belong to the group of the task
/// that the caller is in, if any: where a program cancels that, loops here would end early, and say nothing.
template <typename Work>
auto in_own_group(const Work& work) {
    tbb::task_group_context group(tbb::task_group_context::isolated);
    using Result = std::invoke_result_t<const Work&>;
    if constexpr (std::is_void_v<Result>) {
        tbb::parallel_for(
            0, 1, [&](int) { work(); }, group);
    } else {
        std::optional<Result> result;
        tbb::parallel_for(
            0, 1, [&](int) { result.emplace(work()); }, group);
        return *std::move(result);
    }
}

/// The same with the threads of an arena.
template <typename Work>
auto execute_in(tbb::task_arena& arena, const Work& work) {
    return arena.execute([&] { return in_own_group(work); });
}

}  // namespace clbvh
