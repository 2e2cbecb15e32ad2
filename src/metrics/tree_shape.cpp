#include "clbvh/metrics/tree_shape.hpp"

#include <algorithm>
#include <cstddef>
#include <string>

#include "clbvh/core/error.hpp"
#include "core/exact_areas.hpp"

namespace clbvh {
namespace {

/// exact_half_area() of the box that both nodes share; 0 where they are apart.
double shared_area(const Node& a, const Node& b) {
    Node shared{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        shared.lower[axis] = std::max(a.lower[axis], b.lower[axis]);
        shared.upper[axis] = std::min(a.upper[axis], b.upper[axis]);
        if (!(shared.lower[axis] <= shared.upper[axis])) return 0.0;
    }
    return exact_half_area(shared);
}

[[noreturn]] void refuse(std::size_t node, const std::string& why) {
    throw Error(ErrorCode::invalid_input,
                "node " + std::to_string(node) + ": " + why + "; this is no tree: see what validate() says of it");
}

void count(std::vector<std::uint64_t>& histogram, std::size_t value) {
    if (histogram.size() <= value) histogram.resize(value + 1, 0);
    ++histogram[value];
}

}  // namespace

double TreeShape::mean_leaf_depth() const noexcept {
    double sum = 0.0;
    for (std::size_t depth = 0; depth < leaves_by_depth.size(); ++depth)
        sum += static_cast<double>(depth) * static_cast<double>(leaves_by_depth[depth]);
    return leaves > 0 ? sum / static_cast<double>(leaves) : 0.0;
}

TreeShape tree_shape(const Bvh& bvh) {
    struct Visit {
        std::size_t node;
        std::size_t depth;
    };
    TreeShape shape;
    double overlap = 0.0;
    std::vector<Visit> stack;
    if (!bvh.empty()) stack.push_back({0, 0});
    while (!stack.empty()) {
        const auto [index, depth] = stack.back();
        stack.pop_back();
        if (++shape.nodes > bvh.nodes.size()) refuse(index, "more nodes are met than there are");
        const Node& node = bvh.nodes[index];
        if (node.is_leaf()) {
            if (node.count > bvh.primitive_ids.size()) refuse(index, "it has more primitives than there are ids");
            ++shape.leaves;
            shape.references += node.count;
            count(shape.leaves_by_depth, depth);
            count(shape.leaves_by_size, node.count);
            continue;
        }
        const std::size_t first = node.first;
        if (first + 1 >= bvh.nodes.size()) refuse(index, "its children are out of range");
        overlap += shared_area(bvh.nodes[first], bvh.nodes[first + 1]);
        stack.push_back({first + 1, depth + 1});
        stack.push_back({first, depth + 1});
    }
    const double root_area = bvh.empty() ? 0.0 : exact_half_area(bvh.nodes[0]);
    shape.sibling_overlap = root_area > 0.0 ? overlap / root_area : 0.0;
    return shape;
}

}  // namespace clbvh
