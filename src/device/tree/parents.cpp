#include "device/tree/parents.hpp"

#include "clbvh/core/bvh.hpp"

namespace clbvh::device {
ProgramSpec parents_program(std::size_t work_group_size) {
    return {"parents.cl", work_group_size, ""};
}

std::size_t slot_groups(std::uint32_t node_count) {
    return (std::size_t{node_count} + kSlotsPerGroup - 1) / kSlotsPerGroup;
}

void launch_parents(Launcher& launcher, std::size_t work_group_size, const TreeNodes& tree, const cl::Buffer& parents) {
    launch_on_tree(launcher, launcher.session().kernel(parents_program(work_group_size), "find_parents"),
                   slot_groups(tree.node_count), tree, parents);
    launcher.count_bytes(sizeof(Node) * std::uint64_t{tree.node_count} + sizeof(cl_uint) * tree.node_count / 2);
}

}  // namespace clbvh::device
