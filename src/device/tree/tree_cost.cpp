#include "device/tree/tree_cost.hpp"

namespace clbvh::device {

ProgramSpec tree_cost_program(std::size_t work_group_size) {
    return {"tree_cost.cl", work_group_size, ""};
}

void launch_cost_sums(Launcher& launcher, std::size_t work_group_size, const TreeNodes& tree, const SahCosts& costs,
                      const CostSums& sums) {
    launch_on_tree(launcher, launcher.session().kernel(tree_cost_program(work_group_size), "sum_costs"),
                   slot_groups(tree.node_count), tree, static_cast<float>(costs.inner),
                   static_cast<float>(costs.primitive), sums.partial, sums.root_area);
    launcher.count_bytes(sizeof(Node) * std::uint64_t{tree.node_count});
}

void launch_flat_cost_sums(Launcher& launcher, std::size_t work_group_size, const TreeNodes& tree,
                           const SahCosts& costs, const cl::Buffer& partial, std::uint32_t count) {
    launch_on_tree(launcher, launcher.session().kernel(tree_cost_program(work_group_size), "sum_flat_costs"), count,
                   tree, static_cast<float>(costs.inner), static_cast<float>(costs.primitive), partial);
}

void launch_cost(Launcher& launcher, std::size_t work_group_size, const CostSums& sums, std::uint32_t count,
                 const Block& sah) {
    launcher.launch(launcher.session().kernel(tree_cost_program(work_group_size), "divide_costs"), 1, sums.partial,
                    count, sums.root_area, sah.buffer, sah.offset);
}

}  // namespace clbvh::device
