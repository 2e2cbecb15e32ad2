#include <algorithm>
#include <vector>

#include "clbvh/layout/pair.hpp"
#include "core/tree_walk.hpp"
#include "layout/leaf_check.hpp"

namespace clbvh {
namespace {

using namespace layout;

/// Goes over the nodes once, in their order.
class PairCheck {
public:
    PairCheck(const PairLayout& layout, const Primitives& primitives)
        : layout_(layout), leaves_(primitives, layout.primitive_count, layout.split_references, false) {}

    void run() {
        // Nothing has the root's box.
        if (!layout_.empty()) children_.push_back({0, {kLowest, kHighest}, 0});
        for (std::size_t i = 0; i < layout_.nodes.size(); ++i) {
            if (children_.empty()) reject_layout(name_node(i) + ": it is behind the last of the tree");
            const Child child = children_.back();
            children_.pop_back();
            depth_ = std::max(depth_, child.depth);
            if (child.parent_link != i) {
                reject_layout(name_node(i) + ": its parent has " + std::to_string(child.parent_link) +
                              " for its number");
            }
            enter(i, child);
        }
        if (!children_.empty()) reject_layout("the last nodes are missing");
        if (ids_ != layout_.primitive_ids.size())
            reject_layout("there are primitive ids behind those of the last leaf");
        check_depth(layout_.depth, depth_);
        leaves_.finish();
    }

private:
    static constexpr Vec3 kLowest{kNegativeInfinity, kNegativeInfinity, kNegativeInfinity};
    static constexpr Vec3 kHighest{kPositiveInfinity, kPositiveInfinity, kPositiveInfinity};

    /// A node that is to come.
    struct Child {
        std::size_t parent_link;  ///< Its number, as its parent has it.
        Aabb box;
        std::size_t depth;
    };

    void enter(std::size_t i, const Child& child) {
        const PairNode& node = layout_.nodes[i];
        if (node.is_leaf()) return enter_leaf(i, child.box);
        if (!contains(child.box, node.left_bounds()) || !contains(child.box, node.right_bounds()))
            reject_layout(name_node(i) + ": the box of a child is not within that which its parent has for it");
        children_.push_back({node.right, node.right_bounds(), child.depth + 1});
        children_.push_back({node.left, node.left_bounds(), child.depth + 1});
    }

    void enter_leaf(std::size_t i, const Aabb& box) {
        const PairNode& leaf = layout_.nodes[i];
        if (leaf.first != ids_ || leaf.count > layout_.primitive_ids.size() - ids_) {
            reject_layout(name_node(i) + ": its primitives begin at " + std::to_string(leaf.first) + " and are " +
                          std::to_string(leaf.count) + ", where those behind the leaf before it begin at " +
                          std::to_string(ids_));
        }
        leaves_.add(i, box, {layout_.primitive_ids.data() + ids_, leaf.count});
        ids_ += leaf.count;
    }

    const PairLayout& layout_;
    LeafCheck leaves_;
    std::vector<Child> children_;  ///< The next is the last.
    std::size_t ids_ = 0;          ///< Of the leaves so far.
    std::size_t depth_ = 0;
};

}  // namespace

void validate(const PairLayout& layout, const Primitives& primitives) {
    PairCheck(layout, primitives).run();
}

}  // namespace clbvh
