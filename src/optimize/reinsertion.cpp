#include "optimize/reinsertion.hpp"

#include <array>

#include "core/exact_areas.hpp"
#include "core/half_areas.hpp"
#include "core/simd/prefetch.hpp"

namespace clbvh::optimizer {

/// Beside `node`, which has that area, the subtree would gain so much. The places below go onto the stack, of `size`
/// entries, unless they cannot be better. Returns the stack's new size.
std::size_t ReinsertionSearch::consider(float gain, float area, std::uint32_t node, const Subtree& subtree,
                                        Reinsertion& best, std::size_t size) {
    if (gain > best.gain) best = {best.from, node, gain};
    const float saved_below = gain + area;
    if (saved_below - subtree.area <= best.gain || tree_[node].is_leaf()) return size;
    stack_[size] = {saved_below, tree_[node].first};
    prefetch(&tree_[tree_[node].first]);
    return size + 1;
}

std::size_t ReinsertionSearch::visit_pair(const Place& place, const Subtree& subtree, Reinsertion& best,
                                          std::size_t size) {
    const Box4 left = tree_.box(place.pair);
    const Box4 right = tree_.box(place.pair + 1);
    Box4 with_left = left;
    Box4 with_right = right;
    with_left.merge(subtree.box);
    with_right.merge(subtree.box);
    const std::array<float, 4> areas = half_areas({left, right, with_left, with_right});
    size = consider(place.saved - areas[2], areas[0], place.pair, subtree, best, size);
    return consider(place.saved - areas[3], areas[1], place.pair + 1, subtree, best, size);
}

void ReinsertionSearch::look_below(float saved, std::uint32_t node, const Subtree& subtree, Reinsertion& best) {
    const Box4 there = tree_.box(node);
    Box4 both = there;
    both.merge(subtree.box);
    std::size_t size = consider(saved - both.half_area(), there.half_area(), node, subtree, best, 0);
    while (size > 0) {
        const Place place = stack_[--size];
        // A new parent is no smaller than the subtree.
        if (place.saved - subtree.area <= best.gain) continue;
        if (stack_.size() < size + 2) stack_.resize(2 * size + 64);
        size = visit_pair(place, subtree, best, size);
    }
}

Reinsertion ReinsertionSearch::find(std::uint32_t from) {
    const Subtree subtree{tree_.box(from), tree_.box(from).half_area()};
    Reinsertion best{from, from, 0.0f};
    std::uint32_t node = from;  // whose sibling is looked below
    std::uint32_t above = tree_.parent(from);
    float saved = tree_.box(above).half_area();
    Box4 remaining = tree_.box(EditTree::sibling(from));  // of what is below `above` without the subtree
    look_below(saved, EditTree::sibling(from), subtree, best);
    while (above != 0) {
        node = above;
        above = tree_.parent(node);
        look_below(saved, EditTree::sibling(node), subtree, best);
        remaining.merge(tree_.box(EditTree::sibling(node)));
        const Box4 there = tree_.box(above);
        const float before = there.half_area();
        saved += before - remaining.half_area();
        // Beside all the rest of what is below `above`, with which it makes the box that is there now.
        if (saved - before > best.gain) best = {from, above, saved - before};
        // No ancestor shrinks any more, and a new parent is no smaller than the subtree.
        const bool is_inside = all_at_most(remaining.lower, there.lower) && all_at_most(there.upper, remaining.upper);
        if (is_inside && saved - subtree.area <= best.gain) break;
    }
    return best;
}

bool ReinsertionMove::is_possible(std::uint32_t from, std::uint32_t to) const {
    const std::uint32_t parent = tree_.parent(from);
    if (parent == 0 || to == parent || to == EditTree::sibling(from)) return false;
    // Other moves may have put the target into the subtree.
    for (std::uint32_t slot = to; slot != 0; slot = tree_.parent(slot)) {
        if (slot == from) return false;
    }
    return true;
}

double ReinsertionMove::make(std::uint32_t from, std::uint32_t to) {
    if (!is_possible(from, to)) return 0.0;
    const std::uint32_t sibling = EditTree::sibling(from);
    const std::uint32_t parent = tree_.parent(from);
    journal_.clear();
    double saved = exact_half_area(tree_[parent]);
    write(parent, tree_[sibling]);
    saved += refit_upwards(parent);
    // The pair that this frees becomes that of the new parent.
    write(sibling, tree_[to]);
    Box4 both = tree_.box(sibling);
    both.merge(tree_.box(from));
    write(to, make_node(both, from & ~1u, 0));
    saved -= exact_half_area(tree_[to]);
    saved += refit_upwards(to);
    if (saved > 0.0) return saved;
    undo();
    return 0.0;
}

void ReinsertionMove::write(std::uint32_t slot, const Node& node) {
    journal_.push_back({slot, tree_[slot]});
    tree_[slot] = node;
    tree_.adopt(slot);
}

/// Brings the boxes of the slot's ancestors up to date; returns the area that this saves.
double ReinsertionMove::refit_upwards(std::uint32_t slot) {
    double saved = 0.0;
    while (slot != 0) {
        slot = tree_.parent(slot);
        const Node before = tree_[slot];
        if (!tree_.refit(slot)) break;
        journal_.push_back({slot, before});
        saved += exact_half_area(before) - exact_half_area(tree_[slot]);
    }
    return saved;
}

void ReinsertionMove::undo() {
    for (auto saved = journal_.rbegin(); saved != journal_.rend(); ++saved) {
        tree_[saved->slot] = saved->node;
        tree_.adopt(saved->slot);
    }
}

}  // namespace clbvh::optimizer
