#include "metrics/leaf_order.hpp"

#include <limits>
#include <string>
#include <utility>

#include "clbvh/core/error.hpp"

namespace clbvh {
namespace {

[[noreturn]] void refuse(std::uint32_t node, const std::string& why) {
    throw Error(ErrorCode::invalid_input,
                "node " + std::to_string(node) + ": " + why +
                    "; this is no tree over this mesh: build one, or see what validate() says");
}

/// Throws unless what the node refers to is there.
void check_node(const Bvh& bvh, std::uint32_t index, std::uint64_t triangle_count) {
    const Node& node = bvh.nodes[index];
    if (!node.is_leaf()) {
        if (std::uint64_t{node.first} + 1 >= bvh.nodes.size()) refuse(index, "its children are out of range");
        return;
    }
    if (std::uint64_t{node.first} + node.count > bvh.primitive_ids.size()) refuse(index, "its ids are out of range");
    for (std::size_t slot = node.first; slot < std::size_t{node.first} + node.count; ++slot) {
        if (bvh.primitive_ids[slot] >= triangle_count) {
            refuse(index, "its primitive " + std::to_string(bvh.primitive_ids[slot]) + " is out of range");
        }
    }
}

}  // namespace

LeafOrder::LeafOrder(const Bvh& bvh, std::uint64_t triangle_count) {
    number_references(bvh, triangle_count);
    list_references(triangle_count);
}

void LeafOrder::number_references(const Bvh& bvh, std::uint64_t triangle_count) {
    ranges_.resize(bvh.nodes.size());
    std::vector<bool> is_met(bvh.nodes.size(), false);
    std::vector<std::uint32_t> stack;
    if (!bvh.empty()) stack.push_back(0);
    while (!stack.empty()) {
        const std::uint32_t index = stack.back();
        stack.pop_back();
        if (is_met[index]) refuse(index, "it has two parents, or is its own ancestor");
        is_met[index] = true;
        check_node(bvh, index, triangle_count);
        nodes_.push_back(index);
        const Node& node = bvh.nodes[index];
        ranges_[index].begin = static_cast<std::uint32_t>(triangles_.size());
        if (node.is_leaf()) {
            const auto ids = std::span(bvh.primitive_ids).subspan(node.first, node.count);
            triangles_.insert(triangles_.end(), ids.begin(), ids.end());
            if (triangles_.size() > std::numeric_limits<std::uint32_t>::max()) refuse(index, "too many references");
        } else {
            stack.push_back(node.first + 1);
            stack.push_back(node.first);
        }
    }
    // Children come behind their parent, the second one's subtree last.
    for (std::size_t i = nodes_.size(); i-- > 0;) {
        const std::uint32_t index = nodes_[i];
        const Node& node = bvh.nodes[index];
        ranges_[index].end = node.is_leaf() ? ranges_[index].begin + node.count : ranges_[node.first + 1].end;
    }
}

void LeafOrder::list_references(std::uint64_t triangle_count) {
    // Begins are counted one place too far, and come to stand where they belong while the lists are filled.
    begins_.assign(triangle_count + 1, 0);
    for (const std::uint32_t triangle : triangles_)
        ++begins_[triangle + 1];
    std::uint64_t before = 0;
    for (std::uint64_t& begin : begins_)
        before += std::exchange(begin, before);
    references_.resize(triangles_.size());
    for (std::size_t reference = 0; reference < triangles_.size(); ++reference)
        references_[begins_[triangles_[reference] + 1]++] = static_cast<std::uint32_t>(reference);
}

}  // namespace clbvh
