#pragma once

#include "clbvh/metrics/sah.hpp"
#include "device/tree/parents.hpp"

namespace clbvh::device {

/// The kernels of this stage.
[[nodiscard]] ProgramSpec tree_cost_program(std::size_t work_group_size);

/// Sums of area times cost over parts of a tree, and its root's area; of cost alone where that is 0.
struct CostSums {
    cl::Buffer partial;    ///< float [2 * count]
    cl::Buffer root_area;  ///< float
};

/// Fills `sums`, partial for slot_groups(tree.node_count). One launch.
void launch_cost_sums(Launcher& launcher, std::size_t work_group_size, const TreeNodes& tree, const SahCosts& costs,
                      const CostSums& sums);

/// Replaces `count` sums of area times cost by those of cost alone where the tree's root has no area. One launch.
void launch_flat_cost_sums(Launcher& launcher, std::size_t work_group_size, const TreeNodes& tree,
                           const SahCosts& costs, const cl::Buffer& partial, std::uint32_t count);

/// Writes the SAH cost that `count` sums stand for, a float, to `sah`. One launch.
void launch_cost(Launcher& launcher, std::size_t work_group_size, const CostSums& sums, std::uint32_t count,
                 const Block& sah);

}  // namespace clbvh::device
