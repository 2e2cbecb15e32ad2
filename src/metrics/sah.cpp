// Surface area heuristic. Aila, Karras, Laine 2013, "On Quality Metrics of Bounding Volume Hierarchies", equation 1.
#include "clbvh/metrics/sah.hpp"

#include <cmath>
#include <sstream>
#include <string_view>
#include <vector>

#include "clbvh/core/error.hpp"

namespace clbvh {
namespace {

/// Half the surface area in double precision; only ratios of areas matter.
double area(const Node& node) {
    const double x = double{node.upper[0]} - double{node.lower[0]};
    const double y = double{node.upper[1]} - double{node.lower[1]};
    const double z = double{node.upper[2]} - double{node.lower[2]};
    return x * y + y * z + z * x;
}

void check_cost(std::string_view name, double cost) {
    if (std::isfinite(cost) && cost >= 0.0) return;
    std::ostringstream message;
    message << "the SAH cost of " << name << " is " << cost << "; it must be finite and not negative";
    throw Error(ErrorCode::invalid_input, message.str());
}

}  // namespace

double sah_cost(const Bvh& bvh, const SahCosts& costs) {
    check_cost("an inner node", costs.inner);
    check_cost("a primitive", costs.primitive);
    if (bvh.empty()) return 0.0;

    const double root_area = area(bvh.nodes[0]);
    double total = 0.0;
    std::vector<std::uint32_t> stack{0};
    while (!stack.empty()) {
        const Node& node = bvh.nodes[stack.back()];
        stack.pop_back();
        const double hit_probability = root_area > 0.0 ? area(node) / root_area : 1.0;
        total += hit_probability * (node.is_leaf() ? costs.primitive * node.count : costs.inner);
        if (node.is_leaf()) continue;
        stack.push_back(node.first + 1);
        stack.push_back(node.first);
    }
    return total;
}

}  // namespace clbvh
