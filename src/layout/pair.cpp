// Aila, Laine 2009, "Understanding the Efficiency of Ray Traversal on GPUs", in the format of tinybvh's BVH_GPU.
#include "clbvh/layout/pair.hpp"

#include <vector>

#include "layout/depth_first_layout.hpp"

namespace clbvh {
namespace {

using namespace layout;

PairNode make_inner(const Node* children, std::uint32_t left, std::uint32_t right) {
    const Node& l = children[0];
    const Node& r = children[1];
    return {{l.lower[0], l.lower[1], l.lower[2]}, left, {l.upper[0], l.upper[1], l.upper[2]}, right,
            {r.lower[0], r.lower[1], r.lower[2]}, 0,    {r.upper[0], r.upper[1], r.upper[2]}, 0};
}

PairNode make_leaf(std::uint32_t first, std::uint32_t count) {
    PairNode leaf{};
    leaf.count = count;
    leaf.first = first;
    return leaf;
}

/// Writes the nodes of one part.
class PairWriter {
public:
    PairWriter(const Bvh& bvh, PairNode* result, IdWriter& ids)
        : nodes_(bvh.nodes.data()), result_(result), ids_(ids) {}

    void write(const Part& part) {
        if (!part.is_subtree) {
            const std::uint32_t left = part.first_node + 1;
            result_[part.first_node] =
                make_inner(&nodes_[nodes_[part.node].first], left, left + part.nodes_of_first_child);
            return;
        }
        std::uint32_t node = part.node, number = part.first_node, id = part.first_id;
        for (;; ++number) {
            const Node& read = nodes_[node];
            if (!read.is_leaf()) {
                result_[number] = make_inner(&nodes_[read.first], number + 1, 0);
                second_children_.push_back({read.first + 1, number});
                node = read.first;
                continue;
            }
            result_[number] = make_leaf(id, read.count);
            ids_.write(read, id);
            id += read.count;
            if (second_children_.empty()) return;
            result_[second_children_.back().parent].right = number + 1;
            node = second_children_.back().node;
            second_children_.pop_back();
        }
    }

private:
    /// A node that waits for all below its sibling to be written.
    struct SecondChild {
        std::uint32_t node;
        std::uint32_t parent;  ///< Number of it.
    };

    const Node* nodes_;
    PairNode* result_;
    IdWriter& ids_;
    std::vector<SecondChild> second_children_;
};

}  // namespace

void make_layout(const Bvh& bvh, PairLayout& result, const LayoutOptions& options) {
    make_depth_first(bvh, result, options,
                     [&](const Part& part, IdWriter& ids) { PairWriter(bvh, result.nodes.data(), ids).write(part); });
}

}  // namespace clbvh
