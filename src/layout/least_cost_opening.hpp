#pragma once

#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "clbvh/layout/layout_array.hpp"
#include "layout/opening_rules.hpp"

// Which nodes of two children a wide tree of the least SAH cost opens. Ylitie, Karras, Laine 2017, section 3.1: with
// C(n, i) the least cost of all that is below node n in i slots of a wide node or fewer, and A the half area,
//
//     C(n, 1) = least of  A(n) * kBlockCost                            up to Joined primitives: one leaf
//                         A(n) * kNodeCost + D(n, Width)               a wide node
//     C(n, i) = least of  D(n, i), C(n, i - 1)
//     D(n, j) = least of  C(left, k) + C(right, j - k), 0 < k < j      its slots shared out
//
// Where the paper counts primitives, whole blocks are counted here, since those are tested at once. A leaf of the
// binary tree stays one: what it costs is the same in every tree.
namespace clbvh::layout {

/// Of the visit of a node, and of the test of a block.
inline constexpr float kNodeCost = 1.0f;
inline constexpr float kBlockCost = 1.0f;

/// `Rules` are OpeningRules. Made again and again in the memory that it has.
template <typename Rules>
class LeastCostOpening {
public:
    static constexpr std::uint32_t Width = Rules::Width;

    /// `nodes` are a tree, and not empty. In parallel; what comes out depends on the tree alone. Keeps its memory.
    void run(std::span<const Node> nodes) {
        constexpr std::size_t kNodesOfPart = 8192;
        constexpr std::size_t kMostParts = 256;
        nodes_ = nodes;
        plans_.resize_for_overwrite(nodes.size());
        std::vector<std::uint32_t> top{0};  // behind `opened` the roots of the parts
        std::size_t opened = 0;
        for (const std::size_t wanted = std::min(nodes.size() / kNodesOfPart, kMostParts);
             opened < top.size() && top.size() - opened < wanted;) {
            const Node& node = nodes[top[opened++]];
            if (!node.is_leaf()) top.insert(top.end(), {node.first, node.first + 1});
        }
        tbb::parallel_for(
            opened, top.size(), [&](std::size_t i) { plan_part(top[i]); }, tbb::simple_partitioner{});
        while (opened > 0)
            plan(top[--opened]);
    }

    /// Whether all that is below a node is cheapest in one leaf.
    [[nodiscard]] bool is_joined(std::uint32_t node) const noexcept { return plans_[node].first_share[0] > 0; }
    /// The same of the root, which has a wide node above it in any case.
    [[nodiscard]] bool is_joined_root() const noexcept {
        return plans_[0].primitives <= Rules::Joined && block_cost(0) <= plans_[0].distributed;
    }

    /// How many of `slots`, 2 or more, the first child of an inner node gets, the second the rest; 0 where one slot
    /// less is as good. All slots of a wide node are always shared out.
    [[nodiscard]] std::uint32_t first_share(std::uint32_t node, std::uint32_t slots) const noexcept {
        return plans_[node].first_share[slots - 1];
    }

private:
    /// Of one node.
    struct Plan {
        std::array<float, Width - 1> costs;           ///< C of 1 slot, of 2, up to Width - 1.
        std::array<std::uint8_t, Width> first_share;  ///< See first_share(); of 1 slot: 1 for a joined leaf.
        float distributed;                            ///< D of Width slots; infinite for a leaf.
        std::uint32_t primitives;                     ///< Below it, at most Joined + 1.
        std::uint32_t slots;                          ///< More than these cost no less; at most Width - 1.
    };

    [[nodiscard]] float half_area_of(std::uint32_t index) const noexcept {
        const float area = half_area(nodes_[index].bounds());
        return area > 0.0f ? area : 0.0f;  // not that of boxes with a NaN
    }

    /// Of one leaf of a node.
    [[nodiscard]] float block_cost(std::uint32_t index) const noexcept {
        const std::uint32_t blocks = (std::max(nodes_[index].count, 1U) + Rules::Block - 1) / Rules::Block;
        return half_area_of(index) * kBlockCost * static_cast<float>(blocks);
    }

    /// Children before their parents.
    void plan_part(std::uint32_t root) {
        std::vector<std::uint32_t> order{root};
        for (std::size_t i = 0; i < order.size(); ++i) {
            const Node& node = nodes_[order[i]];
            if (!node.is_leaf()) order.insert(order.end(), {node.first, node.first + 1});
        }
        for (std::size_t i = order.size(); i-- > 0;)
            plan(order[i]);
    }

    void plan(std::uint32_t index) {
        const Node& node = nodes_[index];
        Plan& result = plans_[index];
        result.first_share.fill(0);
        if (node.is_leaf()) {
            result.costs[0] = block_cost(index);
            result.slots = 1;
            result.distributed = std::numeric_limits<float>::infinity();
            result.primitives = std::min(node.count, Rules::Joined + 1);
            return;
        }
        const Plan& a = plans_[node.first];
        const Plan& b = plans_[node.first + 1];
        const std::uint32_t most = std::min(a.slots + b.slots, Width);
        std::array<float, Width + 1> shared{};  // D of so many slots
        for (std::uint32_t slots = 2; slots <= most; ++slots)
            shared[slots] = distribute(a, b, slots, result.first_share[slots - 1]);
        result.first_share[Width - 1] = result.first_share[most - 1];
        result.distributed = shared[most];
        result.primitives = std::min(a.primitives + b.primitives, Rules::Joined + 1);
        result.slots = std::min(most, Width - 1);
        result.costs[0] = half_area_of(index) * kNodeCost + result.distributed;
        if (result.primitives <= Rules::Joined && block_cost(index) <= result.costs[0]) {
            result.costs[0] = block_cost(index);
            result.first_share[0] = 1;
        }
        for (std::uint32_t slots = 2; slots <= result.slots; ++slots) {
            const bool is_cheaper = shared[slots] < result.costs[slots - 2];
            result.costs[slots - 1] = is_cheaper ? shared[slots] : result.costs[slots - 2];
            if (!is_cheaper) result.first_share[slots - 1] = 0;
        }
    }

    /// D; where several shares cost the same, the smallest. No child gets more slots than it has a use for.
    [[nodiscard]] static float distribute(const Plan& a, const Plan& b, std::uint32_t slots, std::uint8_t& share) {
        float least = std::numeric_limits<float>::infinity();
        const std::uint32_t first = slots > b.slots ? slots - b.slots : 1;
        share = static_cast<std::uint8_t>(first);
        for (std::uint32_t k = first; k <= std::min(slots - 1, a.slots); ++k) {
            const float cost = a.costs[k - 1] + b.costs[slots - k - 1];
            if (!(cost < least)) continue;
            least = cost;
            share = static_cast<std::uint8_t>(k);
        }
        return least;
    }

    std::span<const Node> nodes_;
    LayoutArray<Plan> plans_;  ///< One per node; of those that the root leads to.
};

}  // namespace clbvh::layout
