#include "optimize/edit_tree.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <functional>

#include "core/bottom_up.hpp"
#include "core/exact_areas.hpp"

namespace clbvh::optimizer {

EditTree::EditTree(std::span<Node> nodes) : nodes_(nodes), parents_(nodes.size() / 2, kUnused) {
    Scratch scratch;
    const auto visit = [this](std::uint32_t node) { parents_[nodes_[node].first / 2] = node; };
    BottomUp<decltype(visit)>(nodes_, scratch, visit).run();
}

double EditTree::inner_half_area() const {
    return tbb::parallel_deterministic_reduce(
        tbb::blocked_range<std::size_t>(1, parents_.size(), 8192), 0.0,
        [&](const auto& pairs, double sum) {
            for (std::size_t pair = pairs.begin(); pair < pairs.end(); ++pair) {
                if (parents_[pair] != kUnused) sum += exact_half_area(nodes_[parents_[pair]]);
            }
            return sum;
        },
        std::plus<>());
}

bool EditTree::refit(std::uint32_t slot) noexcept {
    Node& node = nodes_[slot];
    Box4 merged = box(node.first);
    merged.merge(box(node.first + 1));
    const Node fitted = make_node(merged, node.first, 0);
    if (fitted == node) return false;
    node = fitted;
    return true;
}

}  // namespace clbvh::optimizer
