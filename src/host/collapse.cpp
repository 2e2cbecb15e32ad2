// SAH-optimal leaves, bottom-up. Karras, Aila 2013, "Fast parallel construction of high-quality bounding volume
// hierarchies", section 4.3: each inner node costs the lesser of being kept, over the best that was found for its
// children, and of being a leaf over all primitives below it.
#include "host/collapse.hpp"

#include <algorithm>
#include <array>
#include <span>

#include "core/bottom_up.hpp"
#include "core/check_field.hpp"
#include "core/exact_areas.hpp"
#include "core/memory_errors.hpp"
#include "core/own_group.hpp"
#include "host/build/emit_tree.hpp"

namespace clbvh::host {
namespace {

class Collapser {
public:
    Collapser(const Bvh& tree, const CollapseConfig& config, Scratch& scratch)
        : tree_(tree),
          config_(config),
          scratch_(scratch),
          extents_(scratch.take<Extent>(tree.nodes.size() / 2)),
          costs_(scratch.take<double>(tree.nodes.size() / 2)) {
        extents_[0] = {0, 0};  // what child() adds to a leaf
        costs_[0] = 0.0;
        if (tree.split_references) distinct_ = scratch.take<std::uint8_t>(tree.nodes.size() / 2);
    }

    void run(Bvh& result) {
        const auto visit = [this](std::uint32_t node) { decide(node); };
        BottomUp<decltype(visit)>(tree_.nodes, scratch_, visit).run();
        emit_tree({tree_.nodes, extents_, tree_.primitive_ids}, result);
    }

private:
    static constexpr std::uint8_t kTooMany = kMaxLeafSize + 1;

    struct Child {
        Extent extent;
        double cost;
    };

    /// Chooses between an inner node and a leaf, both children being decided. Whether a child is a leaf, and what is
    /// chosen, is anybody's guess: arithmetic makes the choice, because a branch would stall at every other node.
    void decide(std::uint32_t index) {
        const Node& node = tree_.nodes[index];
        const Child left = child(tree_.nodes[node.first]);
        const Child right = child(tree_.nodes[std::size_t{node.first} + 1]);
        const std::uint32_t sum = left.extent.primitives + right.extent.primitives;
        const std::uint32_t count = tree_.split_references ? count_distinct(node) : sum;
        const double node_area = exact_half_area(node);
        const double inner_cost = double{config_.inner_cost} * node_area + left.cost + right.cost;
        const double leaf_cost = double{config_.primitive_cost} * count * node_area;
        const std::uint32_t merges = (count <= config_.max_leaf_size) & (leaf_cost <= inner_cost);
        const double costs[2] = {inner_cost, leaf_cost};
        costs_[node.first / 2] = costs[merges];
        extents_[node.first / 2] = {(left.extent.pairs + right.extent.pairs + 1) * (1 - merges),
                                    sum - (sum - count) * merges};
    }

    /// A leaf takes nothing from slot 0, and an inner node has no primitives of its own.
    [[nodiscard]] Child child(const Node& node) const noexcept {
        const std::uint32_t pair = node.first / 2 * (node.is_leaf() ? 0 : 1);
        const Extent below = extents_[pair];
        return {{below.pairs, below.primitives + node.count},
                costs_[pair] + double{config_.primitive_cost} * node.count * exact_half_area(node)};
    }

    /// How many primitives are below an inner node, kTooMany where there are more than a leaf takes, or too many ids.
    std::uint32_t count_distinct(const Node& node) {
        const Node& left = tree_.nodes[node.first];
        const Node& right = tree_.nodes[std::size_t{node.first} + 1];
        std::uint8_t count = kTooMany;
        if (may_merge(left) && may_merge(right)) {
            std::array<std::uint32_t, 2 * kMaxFlattenedIds> ids;
            const auto end = collect_ids(right, collect_ids(left, ids.begin()));
            if (end - ids.begin() <= std::ptrdiff_t{kMaxFlattenedIds}) {
                std::sort(ids.begin(), end);
                const auto distinct = std::unique(ids.begin(), end) - ids.begin();
                count = static_cast<std::uint8_t>(std::min<std::ptrdiff_t>(distinct, kTooMany));
            }
        }
        return distinct_[node.first / 2] = count;
    }

    /// False where a leaf over `node` and something else would be too large.
    [[nodiscard]] bool may_merge(const Node& node) const noexcept {
        return (node.is_leaf() ? node.count : distinct_[node.first / 2]) <= config_.max_leaf_size;
    }

    /// The ids below `node`, from `next` on. Not deep: nodes that may merge have few ids.
    template <typename Iterator>
    Iterator collect_ids(const Node& node, Iterator next) const {
        if (node.is_leaf()) return std::copy_n(tree_.primitive_ids.data() + node.first, node.count, next);
        next = collect_ids(tree_.nodes[node.first], next);
        return collect_ids(tree_.nodes[std::size_t{node.first} + 1], next);
    }

    const Bvh& tree_;
    CollapseConfig config_;
    Scratch& scratch_;
    std::span<Extent> extents_;         // of the inner node whose children are pair p
    std::span<double> costs_;           // of the same: area times cost of its subtree
    std::span<std::uint8_t> distinct_;  // of the same, where references are split: primitives, or kTooMany
};

}  // namespace

void collapse(const Bvh& tree, const CollapseConfig& config, Scratch& scratch, Bvh& result) {
    scratch.reset();
    result.primitive_count = tree.primitive_count;
    result.split_references = tree.split_references;
    if (tree.empty()) {
        result.nodes.clear();
        result.primitive_ids.clear();
    } else {
        Collapser(tree, config, scratch).run(result);
    }
}

}  // namespace clbvh::host

namespace clbvh {

Bvh collapse(const Bvh& tree, const CollapseConfig& config) {
    check_range("max_leaf_size", config.max_leaf_size, 1, kMaxLeafSize);
    check_positive("inner_cost", config.inner_cost);
    check_positive("primitive_cost", config.primitive_cost);
    return with_memory_errors("the merging of leaves", [&] {
        Scratch scratch;
        Bvh result;
        in_own_group([&] { host::collapse(tree, config, scratch, result); });
        return result;
    });
}

}  // namespace clbvh
