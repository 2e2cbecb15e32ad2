// Depth-first nodes with links over what is below them: Smits 1998, "Efficiency Issues for Ray Tracing". The second
// child needs no link: it is where the first child's leads to.
#include "clbvh/layout/skip.hpp"

#include <vector>

#include "layout/depth_first_layout.hpp"

namespace clbvh {
namespace {

using namespace layout;

SkipNode make_node(const Node& node, std::uint32_t link) {
    return {
        {node.lower[0], node.lower[1], node.lower[2]}, link, {node.upper[0], node.upper[1], node.upper[2]}, node.count};
}

/// Writes the nodes of one part.
class SkipWriter {
public:
    SkipWriter(const Bvh& bvh, SkipNode* result, IdWriter& ids)
        : nodes_(bvh.nodes.data()), result_(result), ids_(ids) {}

    void write(const Part& part) {
        if (!part.is_subtree) {
            result_[part.first_node] = make_node(nodes_[part.node], part.first_node + part.node_count);
            return;
        }
        std::uint32_t node = part.node, number = part.first_node, id = part.first_id;
        for (;; ++number) {
            const Node& read = nodes_[node];
            result_[number] = make_node(read, id);
            if (!read.is_leaf()) {
                unlinked_.push_back(number);
                second_children_.push_back({read.first + 1, unlinked_.size()});
                node = read.first;
                continue;
            }
            ids_.write(read, id);
            id += read.count;
            if (second_children_.empty()) break;
            link_down_to(second_children_.back().unlinked, number + 1);
            node = second_children_.back().node;
            second_children_.pop_back();
        }
        link_down_to(0, number + 1);
    }

private:
    /// A node that waits for all below its sibling to be written, and how many nodes were without a link until then.
    struct SecondChild {
        std::uint32_t node;
        std::size_t unlinked;
    };

    /// All that is below the nodes after the first `count` has been written.
    void link_down_to(std::size_t count, std::uint32_t link) {
        for (; unlinked_.size() > count; unlinked_.pop_back())
            result_[unlinked_.back()].link = link;
    }

    const Node* nodes_;
    SkipNode* result_;
    IdWriter& ids_;
    std::vector<std::uint32_t> unlinked_;  ///< Numbers of inner nodes, parents before children.
    std::vector<SecondChild> second_children_;
};

}  // namespace

void make_layout(const Bvh& bvh, SkipLayout& result, const LayoutOptions& options) {
    make_depth_first(bvh, result, options,
                     [&](const Part& part, IdWriter& ids) { SkipWriter(bvh, result.nodes.data(), ids).write(part); });
}

}  // namespace clbvh
