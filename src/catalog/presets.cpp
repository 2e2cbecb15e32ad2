#include <algorithm>
#include <string>

#include "clbvh/catalog.hpp"

namespace clbvh {
namespace {

// Measured beside each other, and beside what else there is: docs/presets.md.
constexpr PresetInfo kPresets[] = {
    {.id = "fast", .title = "The tree as plocpp leaves it: for what moves every frame", .builder = "plocpp"},
    {.id = "balanced",
     .title = "The first passes of reinsertion, where most is gained, and merged leaves",
     .builder = "hploc",
     .optimizers = "reinsert",
     .optimize_passes = 2,
     .max_leaf_size = 8},
    {.id = "high",
     .title = "Reinsertion until nothing is gained: for what is traced for seconds",
     .builder = "binned-sah",
     .optimizers = "reinsert",
     .max_leaf_size = 8},
    {.id = "highest",
     .title = "Spatial splits, then reinsertion: for what is traced for minutes",
     .builder = "sbvh",
     .optimizers = "reinsert",
     .max_leaf_size = 8},
};

}  // namespace

std::span<const PresetInfo> presets() noexcept {
    return kPresets;
}

const PresetInfo* find_preset(std::string_view id) noexcept {
    const auto* const preset = std::ranges::find(kPresets, id, &PresetInfo::id);
    return preset == std::end(kPresets) ? nullptr : preset;
}

BuildOptions with_preset(const PresetInfo& preset, BuildOptions options) {
    if (options.optimizers.empty()) {
        options.optimizers = preset.optimizers;
        // The passes are these optimizers': others come with limits of their own.
        if (options.optimize_passes == 0) options.optimize_passes = preset.optimize_passes;
    }
    if (options.max_leaf_size == 0) options.max_leaf_size = preset.max_leaf_size;
    return options;
}

BuildOptions with_preset(std::string_view id, const BuildOptions& options) {
    const PresetInfo* const preset = find_preset(id);
    return preset == nullptr ? options : with_preset(*preset, options);
}

}  // namespace clbvh
