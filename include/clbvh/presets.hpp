#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "clbvh/core/build_options.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// A builder, optimisers and a leaf size that go well together: a point on the front of build time against the cost of
/// rays, see docs/presets.md. Its id stands wherever a builder's may: `Builder("high")`, `--builder high`; for
/// DeviceBuilder only that of "fast".
struct PresetInfo {
    std::string_view id;                ///< "fast", "balanced", "high" or "highest".
    std::string_view title;             ///< One line for people.
    std::string_view builder;           ///< Id of its builder.
    std::string_view optimizers;        ///< As BuildOptions::optimizers.
    std::uint32_t optimize_passes = 0;  ///< As BuildOptions::optimize_passes.
    std::uint32_t max_leaf_size = 0;    ///< As BuildOptions::max_leaf_size.
};

/// Every preset, the fastest first.
[[nodiscard]] CLBVH_API std::span<const PresetInfo> presets() noexcept;

/// The preset of that id; null where there is none.
[[nodiscard]] CLBVH_API const PresetInfo* find_preset(std::string_view id) noexcept;

/// `options` with the preset's values where they are left to it: empty, or 0. Its passes come with its optimisers only.
[[nodiscard]] CLBVH_API BuildOptions with_preset(const PresetInfo& preset, BuildOptions options = {});

/// The same for the id of a builder or of a preset: what a builder made with both runs with.
[[nodiscard]] CLBVH_API BuildOptions with_preset(std::string_view id, const BuildOptions& options);

}  // namespace clbvh
