#include "layout/reject_tree.hpp"

#include <algorithm>
#include <string>

#include "clbvh/core/error.hpp"
#include "core/tree_walk.hpp"

namespace clbvh::layout {
namespace {

std::string find_fault(const Bvh& bvh) {
    TreeWalk walk(bvh);
    std::uint64_t references = 0;
    while (walk.next()) {
        const Node& node = bvh.nodes[walk.node()];
        if (!node.is_leaf()) continue;
        references += node.count;
        if (references > bvh.primitive_ids.size())
            return name_node(walk.node()) + ": its primitive range belongs to other leaves";
        const auto begin = bvh.primitive_ids.begin() + node.first;
        const auto is_out_of_range = [&](std::uint32_t id) { return id >= bvh.primitive_count; };
        const auto found = std::find_if(begin, begin + node.count, is_out_of_range);
        if (found != begin + node.count) {
            return name_node(walk.node()) + ": primitive " + std::to_string(*found) + " is out of range, there are " +
                   std::to_string(bvh.primitive_count) + " primitives";
        }
    }
    return walk.fault();
}

}  // namespace

void reject_tree(const Bvh& bvh) {
    throw Error(ErrorCode::invalid_input,
                "the tree cannot be laid out: " + find_fault(bvh) + "; give a tree that validate() accepts");
}

}  // namespace clbvh::layout
