#include "device/tree/nodes_in_use.hpp"

#include <string>

#include "clbvh/core/error.hpp"

namespace clbvh::device {
namespace {

[[noreturn]] void reject(std::uint32_t node, std::uint32_t first, const std::string& fault) {
    throw Error(ErrorCode::invalid_input, "the nodes form no tree: node " + std::to_string(node) + " has children at " +
                                              std::to_string(first) + ", " + fault);
}

}  // namespace

std::vector<bool> pairs_in_use(const Bvh& tree) {
    std::vector<bool> in_use((tree.nodes.size() + 1) / 2, false);
    if (tree.empty()) return in_use;
    in_use[0] = true;
    std::vector<std::uint32_t> stack{0};
    while (!stack.empty()) {
        const std::uint32_t index = stack.back();
        const Node& node = tree.nodes[index];
        stack.pop_back();
        if (node.is_leaf()) continue;
        if (node.first % 2 != 0) reject(index, node.first, "which is odd");
        if (std::size_t{node.first} + 1 >= tree.nodes.size())
            reject(index, node.first, "there are " + std::to_string(tree.nodes.size()) + " nodes");
        if (in_use[node.first / 2]) reject(index, node.first, "which have another parent or are the root");
        in_use[node.first / 2] = true;
        stack.insert(stack.end(), {node.first + 1, node.first});
    }
    return in_use;
}

}  // namespace clbvh::device
