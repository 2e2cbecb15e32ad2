#include <algorithm>
#include <vector>

#include "clbvh/layout/skip.hpp"
#include "core/tree_walk.hpp"
#include "layout/leaf_check.hpp"

namespace clbvh {
namespace {

using namespace layout;

/// Goes over the nodes once, in their order.
class SkipCheck {
public:
    SkipCheck(const SkipLayout& layout, const Primitives& primitives)
        : layout_(layout), leaves_(primitives, layout.primitive_count, layout.split_references, false) {}

    void run() {
        for (std::size_t i = 0; i < layout_.nodes.size(); ++i) {
            enter_parent(i);
            if (layout_.nodes[i].is_leaf()) {
                enter_leaf(i);
            } else {
                parents_.push_back({i, 0});
            }
            depth_ = std::max(depth_, parents_.size());
        }
        if (ids_ != layout_.primitive_ids.size())
            reject_layout("there are primitive ids behind those of the last leaf");
        check_depth(layout_.depth, depth_);
        leaves_.finish();
    }

private:
    struct Parent {
        std::size_t node;
        int children;
    };

    /// Number of the node behind all that are below node `i`.
    [[nodiscard]] std::size_t end_of(std::size_t i) const {
        const SkipNode& node = layout_.nodes[i];
        return node.is_leaf() ? i + 1 : node.link;
    }

    /// Proves that node `i` is a child of the last parent that has not two yet, or the root, and that its link does not
    /// lead out of there.
    void enter_parent(std::size_t i) {
        const std::size_t end = end_of(i);
        while (!parents_.empty() && parents_.back().children == 2)
            parents_.pop_back();
        if (end < i + 1 || (!layout_.nodes[i].is_leaf() && end < i + 3))
            reject_layout(name_node(i) + ": its link leaves no room for two children");
        if (parents_.empty()) {
            if (end != layout_.nodes.size())
                reject_layout(name_node(i) + ": the root's link is not the number of nodes");
            return;
        }
        Parent& parent = parents_.back();
        const std::size_t parent_end = end_of(parent.node);
        if (++parent.children == 1 ? end >= parent_end : end != parent_end) {
            reject_layout(name_node(i) + ": what is below it ends at " + std::to_string(end) + ", and what is below " +
                          name_node(parent.node) + ", its parent, at " + std::to_string(parent_end));
        }
        if (!contains(layout_.nodes[parent.node].bounds(), layout_.nodes[i].bounds()))
            reject_layout(name_node(i) + ": its box is not within that of " + name_node(parent.node) + ", its parent");
    }

    void enter_leaf(std::size_t i) {
        const SkipNode& leaf = layout_.nodes[i];
        if (leaf.link != ids_ || leaf.count > layout_.primitive_ids.size() - ids_) {
            reject_layout(name_node(i) + ": its primitives begin at " + std::to_string(leaf.link) + " and are " +
                          std::to_string(leaf.count) + ", where those behind the leaf before it begin at " +
                          std::to_string(ids_));
        }
        leaves_.add(i, leaf.bounds(), {layout_.primitive_ids.data() + ids_, leaf.count});
        ids_ += leaf.count;
    }

    const SkipLayout& layout_;
    LeafCheck leaves_;
    std::vector<Parent> parents_;
    std::size_t ids_ = 0;  ///< Of the leaves so far.
    std::size_t depth_ = 0;
};

}  // namespace

void validate(const SkipLayout& layout, const Primitives& primitives) {
    SkipCheck(layout, primitives).run();
}

}  // namespace clbvh
