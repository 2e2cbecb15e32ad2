#pragma once

#include <span>
#include <string_view>

#include "clbvh/core/bvh.hpp"
#include "clbvh/export.h"
#include "clbvh/optimize/budget.hpp"

namespace clbvh {

/// One row of the table of optimisers: functions from a tree to a better one over the same primitives. Each keeps the
/// leaves, lowers the SAH cost or keeps it, and ends by itself.
struct OptimizerInfo {
    std::string_view id;        ///< What users type, for example "reinsert".
    std::string_view title;     ///< One line for people.
    std::string_view paper;     ///< Authors and year.
    bool splits_first = false;  ///< Triangles are split before the tree is built, so that it is for builds alone
                                ///< (BuildOptions::optimizers); optimize() refuses it.
    bool on_device = false;     ///< DeviceOptimizer has it too.
};

/// Every optimiser of the library, in the order in which tables list them.
[[nodiscard]] CLBVH_API std::span<const OptimizerInfo> optimizers() noexcept;

/// The row of `id`. Throws Error(invalid_input) that lists the known ids.
[[nodiscard]] CLBVH_API const OptimizerInfo& find_optimizer(std::string_view id);

/// Throws what find_optimizer throws for the first unknown id of `ids`, ids with commas between them; none are fine.
CLBVH_API void check_optimizers(std::string_view ids);

/// Runs the optimisers of `ids`, ids with commas between them, one after the other with their default settings, each
/// within `budget`. Works in the calling task arena of oneTBB; the same tree on any number of threads. `stats` has the
/// sums of all. Throws what check_optimizers throws, Error(invalid_input) for one that splits triangles first (see
/// OptimizerInfo), and Error(out_of_memory). The functions of clbvh/optimize/ take settings of their own.
[[nodiscard]] CLBVH_API Bvh optimize(Bvh tree, std::string_view ids, const OptimizeBudget& budget = {},
                                     OptimizeStats* stats = nullptr);

}  // namespace clbvh
