#include "tree_extent.hpp"

#include <algorithm>
#include <clbvh/core/error.hpp>
#include <cstddef>
#include <vector>

namespace clbvh::tool {

TreeExtent measure_extent(const Bvh& bvh) {
    struct Visit {
        std::size_t node;
        std::uint32_t depth;
    };
    TreeExtent extent;
    std::vector<Visit> stack;
    if (!bvh.empty()) stack.push_back({0, 0});
    while (!stack.empty()) {
        const Visit visit = stack.back();
        stack.pop_back();
        if (visit.node >= bvh.nodes.size() || extent.nodes == bvh.nodes.size()) {
            throw Error(ErrorCode::device_failure, "the tree is broken; validate it to see where");
        }
        ++extent.nodes;
        extent.depth = std::max(extent.depth, visit.depth);
        const Node& node = bvh.nodes[visit.node];
        if (node.is_leaf()) {
            ++extent.leaves;
            extent.references += node.count;
        } else {
            stack.push_back({std::size_t{node.first} + 1, visit.depth + 1});
            stack.push_back({node.first, visit.depth + 1});
        }
    }
    return extent;
}

}  // namespace clbvh::tool
