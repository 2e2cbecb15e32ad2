#pragma once

#include <cstdint>
#include <vector>

#include "optimize/edit_tree.hpp"

namespace clbvh::optimizer {

/// A subtree and the node beside which it would stand. `gain` is what that saves of the inner nodes' half areas.
struct Reinsertion {
    std::uint32_t from = 0;
    std::uint32_t to = 0;
    float gain = 0.0f;
};

/// Searches the best new place of subtrees; keeps its stack from one search to the next.
class ReinsertionSearch {
public:
    explicit ReinsertionSearch(const EditTree& tree) : tree_(tree) {}

    /// Where `from`, neither the root nor a child of it, would save most; gain 0 where nowhere.
    ///
    /// Without the subtree X, its parent P goes, and the ancestors of P shrink. The search climbs from P to the root,
    /// adding up what that saves, and at each step looks below the other child:
    ///
    ///        G            G
    ///       / \          / \        saved so far: area(P), then + area(G) - area(G without X), ...
    ///      P   U   ->   S   U       beside U: + area(G without X) - area(G) again, - area(U + X)
    ///     / \                       below U:  also - (area(U + X) - area(U))
    ///    X   S
    [[nodiscard]] Reinsertion find(std::uint32_t from);

private:
    struct Subtree {
        Box4 box;
        float area;
    };
    /// Two siblings to be looked at.
    struct Place {
        float saved;  // if the subtree stood beside one of them, but for the area of its new parent
        std::uint32_t pair;
    };

    void look_below(float saved, std::uint32_t node, const Subtree& subtree, Reinsertion& best);
    std::size_t visit_pair(const Place& place, const Subtree& subtree, Reinsertion& best, std::size_t size);
    std::size_t consider(float gain, float area, std::uint32_t node, const Subtree& subtree, Reinsertion& best,
                         std::size_t size);

    const EditTree& tree_;
    std::vector<Place> stack_ = std::vector<Place>(64);
};

/// Makes moves, one after the other, and only such as save area.
class ReinsertionMove {
public:
    explicit ReinsertionMove(EditTree& tree) : tree_(tree) {}

    /// Moves the subtree in slot `from` beside what stands in slot `to` now. Returns what that saves of the inner
    /// nodes' half areas; where it is nothing, or where there is no such move, the tree is left as it was and 0
    /// returned.
    [[nodiscard]] double make(std::uint32_t from, std::uint32_t to);

    /// Calls `visit(slot)` with what the last move that was made has changed, some slots more than once.
    template <typename Visit>
    void for_each_changed(const Visit& visit) const {
        for (const Saved& saved : journal_)
            visit(saved.slot);
    }

private:
    struct Saved {
        std::uint32_t slot;
        Node node;
    };

    [[nodiscard]] bool is_possible(std::uint32_t from, std::uint32_t to) const;
    void write(std::uint32_t slot, const Node& node);
    double refit_upwards(std::uint32_t slot);
    void undo();

    EditTree& tree_;
    std::vector<Saved> journal_;
};

}  // namespace clbvh::optimizer
