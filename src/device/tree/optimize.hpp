#pragma once

#include <string_view>
#include <vector>

#include "clbvh/device/optimizer_options.hpp"
#include "device/tree/device_optimizer_row.hpp"

namespace clbvh::device {

/// Most of DeviceOptimizerOptions::passes.
constexpr std::uint32_t kMostPasses = 1000;

/// An optimiser that was asked for.
struct ChosenOptimizer {
    std::string_view id;  ///< of its row in the table of optimisers
    const DeviceOptimizerRow* row;
};

/// Optimisers that run one after the other, ready for one device.
class OptimizerChain {
public:
    /// None.
    OptimizerChain() = default;
    /// Takes every automatic choice, and builds the programs. Throws Error(invalid_input) for options out of range, and
    /// what Session::prepare throws.
    OptimizerChain(Session& session, std::vector<ChosenOptimizer> optimizers, const DeviceOptimizerOptions& options);

    [[nodiscard]] bool empty() const noexcept { return optimizers_.empty(); }
    [[nodiscard]] const OptimizeSettings& settings() const noexcept { return settings_; }

    /// Scratch for a tree of up to so many nodes, which the optimisers share; 0 where there is nothing to do.
    [[nodiscard]] std::uint64_t scratch_bytes(std::uint32_t node_count) const;

    /// Enqueues the optimisers, each as a stage of its id, from `begin` of the whole on. Waits for nothing. `scratch`
    /// is aligned for views, and may have no buffer where it takes no bytes.
    void launch(Launcher& launcher, const TreeNodes& tree, const Block& scratch, double begin) const;

private:
    std::vector<ChosenOptimizer> optimizers_;
    OptimizeSettings settings_;
};

}  // namespace clbvh::device
