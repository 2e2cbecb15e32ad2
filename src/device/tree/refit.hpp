#pragma once

#include "clbvh/metrics/sah.hpp"
#include "device/build/build_buffers.hpp"
#include "device/opencl/launcher.hpp"
#include "device/tree/parents.hpp"

namespace clbvh::device {

/// How a tree is refitted on one device.
struct RefitSettings {
    Shape shape = Shape::group;       ///< group or lane
    std::size_t work_group_size = 1;  ///< 1 in the lane shape
    std::uint32_t ranges = 1;         ///< work items for the subtrees, in the lane shape
    SahCosts costs;
    BuildSettings build;  ///< for the boxes of the primitives
};

/// Throws Error(unsupported) for what the device cannot run.
[[nodiscard]] RefitSettings resolve_refit_settings(Session& session, Shape shape, const SahCosts& costs);

/// All that refitting runs.
[[nodiscard]] std::vector<ProgramSpec> refit_programs(const RefitSettings& settings);

/// Bytes of what has to be known of a tree's structure.
[[nodiscard]] std::uint64_t refit_order_bytes(const RefitSettings& settings, std::uint32_t node_count);
/// Bytes that a refit needs besides.
[[nodiscard]] std::uint64_t refit_scratch_bytes(const RefitSettings& settings, std::uint32_t node_count,
                                                std::uint32_t primitive_count);
/// Bytes that the cost of a tree needs.
[[nodiscard]] std::uint64_t quality_scratch_bytes(std::uint32_t node_count);

/// Fills `order`. Four launches at most, none where there are no nodes.
void launch_refit_order(Launcher& launcher, const RefitSettings& settings, const TreeNodes& tree, const Block& order);

/// Gives the tree the boxes of the mesh, and writes the cost before and after, two floats, to `sah`. Some nine
/// launches.
void launch_refit(Launcher& launcher, const RefitSettings& settings, const TreeNodes& tree,
                  const cl::Buffer& primitive_ids, const DeviceMesh& mesh, const Block& order, const Block& scratch,
                  const Block& sah);

/// Writes the tree's cost, a float, to `sah`. Two launches.
void launch_quality(Launcher& launcher, const RefitSettings& settings, const TreeNodes& tree, const Block& scratch,
                    const Block& sah);

}  // namespace clbvh::device
