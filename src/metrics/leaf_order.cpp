#include "metrics/leaf_order.hpp"

#include <limits>
#include <span>
#include <string>

#include "clbvh/core/error.hpp"
#include "core/prefix_sum.hpp"
#include "core/tree_walk.hpp"

namespace clbvh {
namespace {

[[noreturn]] void refuse(const std::string& fault) {
    throw Error(ErrorCode::invalid_input,
                fault + "; the tree was not built over this mesh: build one, or see what validate() says");
}

}  // namespace

LeafOrder::LeafOrder(const Bvh& bvh, std::uint64_t triangle_count) {
    number_references(bvh, triangle_count);
    list_references(triangle_count);
}

void LeafOrder::number_references(const Bvh& bvh, std::uint64_t triangle_count) {
    ranges_.resize(bvh.nodes.size());
    TreeWalk walk(bvh);
    while (walk.next()) {
        const Node& node = bvh.nodes[walk.node()];
        nodes_.push_back(walk.node());
        ranges_[walk.node()].begin = static_cast<std::uint32_t>(triangles_.size());
        if (!node.is_leaf()) continue;
        const auto ids = std::span(bvh.primitive_ids).subspan(node.first, node.count);
        for (const std::uint32_t triangle : ids) {
            if (triangle < triangle_count) continue;
            refuse(name_node(walk.node()) + ": its primitive " + std::to_string(triangle) + " is out of range");
        }
        triangles_.insert(triangles_.end(), ids.begin(), ids.end());
        if (triangles_.size() > std::numeric_limits<std::uint32_t>::max())
            refuse(name_node(walk.node()) + ": too many references");
    }
    if (walk.failed()) refuse(walk.fault());
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
    sum_before(std::span(begins_));
    references_.resize(triangles_.size());
    for (std::size_t reference = 0; reference < triangles_.size(); ++reference)
        references_[begins_[triangles_[reference] + 1]++] = static_cast<std::uint32_t>(reference);
}

}  // namespace clbvh
