#pragma once

#include "device/opencl/launcher.hpp"
#include "device/opencl/memory_block.hpp"
#include "kernels/tree/tree_constants.h"

namespace clbvh::device {

/// The nodes of a finished tree in device memory. Slots that no node uses hold zeros.
struct TreeNodes {
    cl::Buffer nodes;              ///< Node [node_count]
    std::uint32_t node_count = 0;  ///< Those in use, or more.
    Block active_count;  ///< A uint of the device's, half the nodes in use; without a buffer all of node_count may be.
};

/// The kernels of this stage.
[[nodiscard]] ProgramSpec parents_program(std::size_t work_group_size);

/// Slots that one group of such a pass takes.
inline constexpr std::uint32_t kSlotsPerGroup = kernels::SLOTS_PER_GROUP;

/// Groups for a pass over all slots of a tree, in kernels that include tree_nodes.clh.
[[nodiscard]] std::size_t slot_groups(std::uint32_t node_count);

/// Launches `kernel` with the arguments of kernels/tree/tree_nodes.clh, nodes first, then `rest`.
template <class... Rest>
void launch_on_tree(Launcher& launcher, Kernel& kernel, std::size_t groups, const TreeNodes& tree,
                    const Rest&... rest) {
    const bool has_count = tree.active_count.buffer() != nullptr;
    // No kernel is given a null buffer.
    const cl::Buffer& count = has_count ? tree.active_count.buffer : tree.nodes;
    launcher.launch(kernel, groups, tree.nodes, tree.node_count, count, tree.active_count.offset,
                    std::uint32_t{has_count}, rest...);
}

/// Fills parents, uint [node_count / 2], with the slot of the parent of each sibling pair in use but the root's. One
/// launch, within a stage of the launcher's.
void launch_parents(Launcher& launcher, std::size_t work_group_size, const TreeNodes& tree, const cl::Buffer& parents);

}  // namespace clbvh::device
