#pragma once

#include <span>
#include <string_view>

#include "clbvh/device/device_optimizer.hpp"
#include "device/device_optimizer_row.hpp"

namespace clbvh::device {

/// An optimiser that was asked for.
struct ChosenOptimizer {
    std::string_view id;  ///< of its row in the table of optimisers
    const DeviceOptimizerRow* row;
};

/// Takes every automatic choice, and builds the programs of the optimisers. Throws Error(invalid_input) for options out
/// of range, and what Session::prepare throws.
[[nodiscard]] OptimizeSettings prepare_optimizers(Session& session, std::span<const ChosenOptimizer> optimizers,
                                                  const DeviceOptimizerOptions& options);

/// Scratch of the optimisers, one after the other, for a tree of up to so many nodes.
[[nodiscard]] std::uint64_t optimizer_scratch_bytes(std::span<const ChosenOptimizer> optimizers,
                                                    const OptimizeSettings& settings, std::uint32_t node_count);

/// Enqueues the optimisers, each as a stage of its id, from `begin` of the whole on. Waits for nothing. Scratch may
/// have no buffer where it takes no bytes.
void launch_optimizers(Launcher& launcher, std::span<const ChosenOptimizer> optimizers,
                       const OptimizeSettings& settings, const TreeNodes& tree, const Block& scratch, double begin);

}  // namespace clbvh::device
