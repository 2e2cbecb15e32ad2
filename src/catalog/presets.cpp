#include <algorithm>
#include <string>

#include "clbvh/catalog.hpp"

namespace clbvh {
namespace {

// Measured beside each other, and beside what else there is: docs/presets.md.
constexpr PresetInfo kPresets[] = {
    {.id = "fast",
     .title = "Leaves of neighbours, clustered: for what moves every frame",
     .builder = "hploc",
     .leaf_size = 4,
     .code_bits = 33},
    {.id = "balanced",
     .title = "The first passes of reinsertion, where most is gained",
     .builder = "hploc",
     .optimizers = "reinsert",
     .optimize_passes = 2,
     .leaf_size = 4},
    {.id = "high",
     .title = "More passes, and leaves merged where that pays: for what is traced for seconds",
     .builder = "hploc",
     .optimizers = "reinsert",
     .optimize_passes = 4,
     .max_leaf_size = 8,
     .leaf_size = 2,
     .opening = NodeOpening::least_cost},
    {.id = "highest",
     .title = "Spatial splits, then reinsertion: for what is traced for minutes",
     .builder = "sbvh",
     .optimizers = "reinsert",
     .optimize_passes = 4,
     .max_leaf_size = 8,
     .split_overlap = 0.4f,
     .opening = NodeOpening::least_cost},
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
    if (preset.leaf_size > 0 && options.hploc.leaf_size == HplocConfig().leaf_size) {
        options.hploc.leaf_size =
            options.max_leaf_size > 0 ? std::min(preset.leaf_size, options.max_leaf_size) : preset.leaf_size;
    }
    if (preset.code_bits > 0 && options.device.code_bits == DeviceConfig().code_bits)
        options.device.code_bits = preset.code_bits;
    if (preset.split_overlap > 0.0f && options.sbvh.overlap == SbvhConfig().overlap)
        options.sbvh.overlap = preset.split_overlap;
    if (options.opening == BuildOptions().opening) options.opening = preset.opening;
    return options;
}

BuildOptions with_preset(std::string_view id, const BuildOptions& options) {
    const PresetInfo* const preset = find_preset(id);
    return preset == nullptr ? options : with_preset(*preset, options);
}

}  // namespace clbvh
