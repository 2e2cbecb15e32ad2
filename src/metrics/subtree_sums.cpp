#include "metrics/subtree_sums.hpp"

#include <cstddef>

#include "core/box_overlap.hpp"
#include "metrics/node_cost.hpp"

namespace clbvh {
SubtreeSums::SubtreeSums(const Bvh& bvh, const LeafOrder& order, const SahCosts& costs) : sums_(bvh.nodes.size()) {
    // Children come behind their parents in the walk.
    for (std::size_t i = order.nodes().size(); i-- > 0;) {
        const std::uint32_t index = order.nodes()[i];
        const Node& node = bvh.nodes[index];
        Sum& sum = sums_[index];
        sum = {node.bounds(), node_cost(node, costs)};
        if (node.is_leaf()) continue;
        for (const std::uint32_t child : {node.first, node.first + 1}) {
            sum.core = intersect(sum.core, sums_[child].core);
            sum.cost += sums_[child].cost;
        }
    }
}

}  // namespace clbvh
