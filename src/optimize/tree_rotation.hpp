#pragma once

#include <array>
#include <cstdint>

#include "core/exact_areas.hpp"
#include "optimize/edit_tree.hpp"

namespace clbvh::optimizer {

/// The exchange of two subtrees below one node, and what it saves of its children's half areas; negative where it
/// costs.
struct TreeRotation {
    std::uint32_t a = 0;  ///< Slots; both 0: none.
    std::uint32_t b = 0;
    double saved = 0.0;

    [[nodiscard]] explicit operator bool() const noexcept { return a != 0; }
};

/// Decides between what was best so far and a candidate, the `index`-th of its node.
struct GreedyChoice {
    [[nodiscard]] bool operator()(const TreeRotation& best, const TreeRotation& candidate,
                                  std::uint32_t /*index*/) const noexcept {
        return candidate.saved > best.saved;
    }
};

/// All exchanges at the inner node `slot` go by `choice`, which keeps the best. Kensler 2008, figure 2:
///
///         N              a child and a grandchild on the other side:  L-RL  L-RR  R-LL  R-LR
///        /   |           two grandchildren:                           LL-RL  LL-RR
///       L     R          (LR-RL and LR-RR would give the same two trees)
///      / |   / |
///    LL  LR RL  RR
template <typename Choice>
[[nodiscard]] TreeRotation best_rotation(const EditTree& tree, std::uint32_t slot, const Choice& choice);

/// Makes the exchange at the inner node `slot`, boxes included.
inline void make_rotation(EditTree& tree, std::uint32_t slot, const TreeRotation& rotation) noexcept {
    tree.exchange(rotation.a, rotation.b);
    for (const std::uint32_t child : {tree[slot].first, tree[slot].first + 1}) {
        if (!tree[child].is_leaf()) static_cast<void>(tree.refit(child));
    }
}

/// The half area of the union, in double precision.
[[nodiscard]] inline double merged_half_area(const Node& a, const Node& b) noexcept {
    Box4 both{Float4::load(a.lower).without_w(), Float4::load(a.upper).without_w()};
    both.merge({Float4::load(b.lower).without_w(), Float4::load(b.upper).without_w()});
    return exact_half_area(make_node(both, 0, 0));
}

template <typename Choice>
TreeRotation best_rotation(const EditTree& tree, std::uint32_t slot, const Choice& choice) {
    TreeRotation best;
    std::uint32_t index = 0;
    const auto consider = [&](const TreeRotation& candidate) {
        if (choice(best, candidate, index++)) best = candidate;
    };
    const std::array<std::uint32_t, 2> children{tree[slot].first, tree[slot].first + 1};
    for (const std::uint32_t near : children) {
        const std::uint32_t far = EditTree::sibling(near);
        if (tree[far].is_leaf()) continue;
        const double area = exact_half_area(tree[far]);
        const std::uint32_t grandchild = tree[far].first;
        // In the far child, `near` takes one grandchild's place beside the other.
        consider({near, grandchild, area - merged_half_area(tree[near], tree[grandchild + 1])});
        consider({near, grandchild + 1, area - merged_half_area(tree[near], tree[grandchild])});
    }
    if (tree[children[0]].is_leaf() || tree[children[1]].is_leaf()) return best;
    const double areas = exact_half_area(tree[children[0]]) + exact_half_area(tree[children[1]]);
    const std::uint32_t left = tree[children[0]].first, right = tree[children[1]].first;
    consider({left, right,
              areas - merged_half_area(tree[right], tree[left + 1]) - merged_half_area(tree[left], tree[right + 1])});
    consider({left, right + 1,
              areas - merged_half_area(tree[right + 1], tree[left + 1]) - merged_half_area(tree[left], tree[right])});
    return best;
}

}  // namespace clbvh::optimizer
