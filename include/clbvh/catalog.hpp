#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "clbvh/core/bvh.hpp"
#include "clbvh/export.h"
#include "clbvh/optimize/budget.hpp"
#include "clbvh/options.hpp"

namespace clbvh {

/// Where a builder runs.
enum class BuilderKind : unsigned char { host, device };

/// One row of the table of builders. Which options it reads, reads_option() says.
struct BuilderInfo {
    std::string_view id;     ///< The name that users type, for example "plocpp".
    std::string_view title;  ///< One line for people.
    std::string_view paper;  ///< Authors and year.
    BuilderKind kind;
};

/// Every builder of the library, in the order in which tables list them.
[[nodiscard]] CLBVH_API std::span<const BuilderInfo> builders() noexcept;

/// The row of `id`, or of the builder that the preset `id` runs (see presets()). Throws Error(invalid_input) that lists
/// the known ids.
[[nodiscard]] CLBVH_API const BuilderInfo& find_builder(std::string_view id);

/// A builder, optimisers and a leaf size that go well together: a point on the front of build time against the cost of
/// rays, see docs/presets.md. Its id stands wherever a builder's may: `Builder("high")`, `--builder high`; for
/// DeviceBuilder only that of "fast".
struct PresetInfo {
    std::string_view id;                               ///< "fast", "balanced", "high" or "highest".
    std::string_view title;                            ///< One line for people.
    std::string_view builder;                          ///< Id of its builder.
    std::string_view optimizers = {};                  ///< As BuildOptions::optimizers.
    std::uint32_t optimize_passes = 0;                 ///< As BuildOptions::optimize_passes.
    std::uint32_t max_leaf_size = 0;                   ///< As BuildOptions::max_leaf_size.
    std::uint32_t leaf_size = 0;                       ///< As HplocConfig::leaf_size; 0: as it is.
    std::uint32_t code_bits = 0;                       ///< As DeviceConfig::code_bits; 0: as it is.
    float split_overlap = 0.0f;                        ///< As SbvhConfig::overlap; 0: as it is.
    NodeOpening opening = NodeOpening::largest_first;  ///< As BuildOptions::opening.
};

/// Every preset, the fastest first.
[[nodiscard]] CLBVH_API std::span<const PresetInfo> presets() noexcept;

/// The preset of that id; null where there is none.
[[nodiscard]] CLBVH_API const PresetInfo* find_preset(std::string_view id) noexcept;

/// `options` with the preset's values where they are left to it: empty, 0, or what a Config begins with. Its passes
/// come with its optimisers only, and its leaves are never larger than max_leaf_size.
[[nodiscard]] CLBVH_API BuildOptions with_preset(const PresetInfo& preset, BuildOptions options = {});

/// The same for the id of a builder or of a preset: what a builder made with both runs with.
[[nodiscard]] CLBVH_API BuildOptions with_preset(std::string_view id, const BuildOptions& options);

/// One row of the table of optimisers: functions from a tree to a better one over the same primitives. Each keeps the
/// leaves, lowers the SAH cost or keeps it, and ends by itself.
struct OptimizerInfo {
    std::string_view id;        ///< The name that users type, for example "reinsert".
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
