#include "device/optimize.hpp"

#include <algorithm>

#include "core/check_field.hpp"
#include "device/build_settings.hpp"

namespace clbvh::device {
namespace {

// Two trees of three leaves may differ.
constexpr std::uint32_t kLeastNodes = 6;

}  // namespace

OptimizeSettings prepare_optimizers(Session& session, std::span<const ChosenOptimizer> optimizers,
                                    const DeviceOptimizerOptions& options) {
    check_range("passes", options.passes, 0, 1000);
    BuildOptions build_options;
    build_options.shape = options.shape;
    const BuildSettings build = resolve_settings(build_options, session, {.chunks = false, .presets = false});
    OptimizeSettings settings;
    settings.shape = build.shape;
    settings.passes = options.passes;
    settings.stream_group_size = build.stream_group_size;
    settings.groups_to_fill = build.groups_to_fill;
    for (const ChosenOptimizer& optimizer : optimizers)
        session.prepare({optimizer.row->programs(settings)});
    return settings;
}

std::uint64_t optimizer_scratch_bytes(std::span<const ChosenOptimizer> optimizers, const OptimizeSettings& settings,
                                      std::uint32_t node_count) {
    std::uint64_t most = 0;
    if (node_count < kLeastNodes) return most;
    for (const ChosenOptimizer& optimizer : optimizers)
        most = std::max(most, optimizer.row->scratch_bytes(settings, node_count / 2 * 2));
    return most;
}

void launch_optimizers(Launcher& launcher, std::span<const ChosenOptimizer> optimizers,
                       const OptimizeSettings& settings, const TreeNodes& tree, const Block& scratch, double begin) {
    if (tree.node_count < kLeastNodes) return;
    TreeNodes pairs = tree;
    pairs.node_count = tree.node_count / 2 * 2;
    for (std::size_t i = 0; i < optimizers.size(); ++i) {
        const double done = static_cast<double>(i) / static_cast<double>(optimizers.size());
        launcher.begin_stage(optimizers[i].id, begin + (1.0 - begin) * done);
        optimizers[i].row->launch({launcher, settings, pairs, scratch});
    }
}

}  // namespace clbvh::device
