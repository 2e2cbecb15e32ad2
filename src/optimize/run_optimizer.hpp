#pragma once

#include <utility>

#include "clbvh/core/bvh.hpp"
#include "clbvh/optimize/budget.hpp"
#include "core/memory_errors.hpp"
#include "core/own_group.hpp"
#include "optimize/pass_clock.hpp"

namespace clbvh::optimizer {

/// Checks the budget, then runs `optimize(tree)` on a tree that has inner nodes; `what` names the work in
/// Error(out_of_memory).
template <typename Optimize>
[[nodiscard]] Bvh run_optimizer(Bvh tree, const OptimizeBudget& budget, const char* what, OptimizeStats* stats,
                                const Optimize& optimize) {
    check_budget(budget);
    OptimizeStats done;
    if (!tree.empty() && !tree.nodes[0].is_leaf())
        done = with_memory_errors(what, [&] { return in_own_group([&] { return optimize(tree); }); });
    if (stats != nullptr) *stats = done;
    return tree;
}

}  // namespace clbvh::optimizer
