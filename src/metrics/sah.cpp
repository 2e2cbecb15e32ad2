// Surface area heuristic. Aila, Karras, Laine 2013, "On Quality Metrics of Bounding Volume Hierarchies", equation 1.
#include "clbvh/metrics/sah.hpp"

#include <vector>

#include "metrics/check_costs.hpp"
#include "metrics/node_area.hpp"
#include "metrics/node_cost.hpp"

namespace clbvh {

double sah_cost(const Bvh& bvh, const SahCosts& costs) {
    check_costs(costs);
    if (bvh.empty()) return 0.0;

    const double root_area = node_area(bvh.nodes[0]);
    double total = 0.0;
    std::vector<std::uint32_t> stack{0};
    while (!stack.empty()) {
        const Node& node = bvh.nodes[stack.back()];
        stack.pop_back();
        const double hit_probability = root_area > 0.0 ? node_area(node) / root_area : 1.0;
        total += hit_probability * node_cost(node, costs);
        if (node.is_leaf()) continue;
        stack.push_back(node.first + 1);
        stack.push_back(node.first);
    }
    return total;
}

}  // namespace clbvh
