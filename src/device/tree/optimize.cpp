#include "device/tree/optimize.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "clbvh/core/error.hpp"
#include "core/check_field.hpp"

namespace clbvh::device {
namespace {

// Two trees of three leaves may differ.
constexpr std::uint32_t kLeastNodes = 6;

OptimizeSettings resolve(Session& session, const DeviceOptimizerOptions& options, Shape shape) {
    OptimizeSettings settings;
    static_cast<DeviceFit&>(settings) = fit_to_device(session, shape);
    settings.passes = options.passes;
    settings.treelet_leaves = options.treelet_leaves;
    settings.hand_over = session.hand_over();
    return settings;
}

/// The settings, in the group shape where the lane shape was not asked for and has too little local memory.
OptimizeSettings resolve(Session& session, const std::vector<ChosenOptimizer>& optimizers,
                         const DeviceOptimizerOptions& options) {
    check_range("passes", options.passes, 0, kMostPasses);
    check_range("treelet_leaves", options.treelet_leaves, 3, 8);
    const OptimizeSettings settings = resolve(session, options, options.shape);
    if (!settings.lane()) return settings;
    const DeviceInfo& info = session.info();
    for (const ChosenOptimizer& optimizer : optimizers) {
        const std::uint64_t bytes = optimizer.row->lane_local_bytes(settings);
        if (bytes <= info.local_memory_bytes) continue;
        if (options.shape != Shape::lane) return resolve(session, options, Shape::group);
        throw Error(ErrorCode::unsupported, std::string(optimizer.id) + " with treelet_leaves " +
                                                std::to_string(options.treelet_leaves) + " in the lane shape needs " +
                                                std::to_string(bytes) + " bytes of local memory, but " + info.name +
                                                " has " + std::to_string(info.local_memory_bytes) +
                                                "; take treelet_leaves 7 or Shape::group");
    }
    return settings;
}

}  // namespace

OptimizerChain::OptimizerChain(Session& session, std::vector<ChosenOptimizer> optimizers,
                               const DeviceOptimizerOptions& options)
    : optimizers_(std::move(optimizers)), settings_(resolve(session, optimizers_, options)) {
    for (const ChosenOptimizer& optimizer : optimizers_) {
        const std::vector<ProgramSpec> programs = optimizer.row->programs(settings_);
        session.prepare({programs});
    }
}

std::uint64_t OptimizerChain::scratch_bytes(std::uint32_t node_count) const {
    std::uint64_t most = 0;
    if (node_count < kLeastNodes) return most;
    for (const ChosenOptimizer& optimizer : optimizers_)
        most = std::max(most, optimizer.row->scratch_bytes(settings_, node_count / 2 * 2));
    return most;
}

void OptimizerChain::launch(Launcher& launcher, const TreeNodes& tree, const Block& scratch, double begin) const {
    if (tree.node_count < kLeastNodes) return;
    TreeNodes pairs = tree;
    pairs.node_count = tree.node_count / 2 * 2;
    for (std::size_t i = 0; i < optimizers_.size(); ++i) {
        const double done = static_cast<double>(i) / static_cast<double>(optimizers_.size());
        launcher.begin_stage(optimizers_[i].id, begin + (1.0 - begin) * done);
        optimizers_[i].row->launch({launcher, settings_, pairs, scratch});
    }
}

}  // namespace clbvh::device
