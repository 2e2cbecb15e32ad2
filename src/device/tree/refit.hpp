#pragma once

#include "clbvh/metrics/sah.hpp"
#include "device/opencl/device_fit.hpp"
#include "device/opencl/launcher.hpp"
#include "device/tree/parents.hpp"
#include "device/tree/tree_cost.hpp"

namespace clbvh::device {

/// How a tree is refitted on one device.
struct RefitSettings : DeviceFit {
    std::uint32_t ranges = 1;  ///< work items for the subtrees, in the lane shape
    SahCosts costs;
    HandOver hand_over = HandOver::within_launch;  ///< never automatic
};

/// Throws Error(unsupported) for what the device cannot run.
[[nodiscard]] RefitSettings resolve_refit_settings(Session& session, Shape shape, const SahCosts& costs);

/// All that refitting runs, but what finds the boxes of the primitives.
[[nodiscard]] std::vector<ProgramSpec> refit_programs(const RefitSettings& settings);

/// Bytes of what has to be known of a tree's structure.
[[nodiscard]] std::uint64_t refit_order_bytes(const RefitSettings& settings, std::uint32_t node_count);

/// Scratch of a refit: the sums of the costs before and after.
struct RefitScratch {
    CostSums before, after;
};
[[nodiscard]] RefitScratch cut_refit_scratch(ArrayLayout& layout, const RefitSettings& settings,
                                             std::uint32_t node_count);

/// Bytes that the cost of a tree needs.
[[nodiscard]] std::uint64_t cost_scratch_bytes(std::uint32_t node_count);

/// Fills `order`. Four launches at most, none where there are no nodes.
void launch_refit_order(Launcher& launcher, const RefitSettings& settings, const TreeNodes& tree, const Block& order);

/// Gives the tree the boxes of its primitives, float[6] each, and writes the cost before and after, two floats, to
/// `sah`. Some seven launches, within a stage of the launcher's.
void launch_refit(Launcher& launcher, const RefitSettings& settings, const TreeNodes& tree,
                  const cl::Buffer& primitive_ids, const cl::Buffer& boxes, const Block& order,
                  const RefitScratch& scratch, const Block& sah);

/// Writes the tree's cost, a float, to `sah`. Two launches.
void launch_tree_cost(Launcher& launcher, const RefitSettings& settings, const TreeNodes& tree, const Block& scratch,
                      const Block& sah);

}  // namespace clbvh::device
