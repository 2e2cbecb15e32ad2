#include "optimize/refit_plan.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <string>

#include "clbvh/core/error.hpp"
#include "core/bottom_up.hpp"

namespace clbvh::optimizer {
namespace {

/// Pairs of the largest subtree that is one thread's work, and of a chunk at least: some tens of microseconds.
constexpr std::uint32_t kSubtreePairs = 2048;

RefitPlan::Visit visit_to_children(std::span<const Node> nodes, const Node& node) {
    return {node.first / 2, nodes[node.first].is_leaf(), nodes[std::size_t{node.first} + 1].is_leaf()};
}

void push_inner_children(std::span<const Node> nodes, const Node& node, std::vector<std::uint32_t>& stack) {
    if (!nodes[std::size_t{node.first} + 1].is_leaf()) stack.push_back(node.first + 1);
    if (!nodes[node.first].is_leaf()) stack.push_back(node.first);
}

/// For each pair the pairs of the subtree that it is the top of.
void count_pairs(std::span<const Node> nodes, std::span<std::uint32_t> sizes) {
    Scratch scratch;
    const auto size_below = [&](std::uint32_t node) {
        return nodes[node].is_leaf() ? 0 : sizes[nodes[node].first / 2];
    };
    const auto visit = [&](std::uint32_t node) {
        const std::uint32_t left = nodes[node].first;
        sizes[left / 2] = 1 + size_below(left) + size_below(left + 1);
    };
    BottomUp<decltype(visit)>(nodes, scratch, visit).run();
}

}  // namespace

RefitPlan::RefitPlan(std::span<const Node> nodes) {
    if (nodes.size() > kMostSlots) {
        throw Error(ErrorCode::unsupported, "a tree of " + std::to_string(nodes.size()) +
                                                " slots for nodes cannot be refitted, the limit is " +
                                                std::to_string(kMostSlots) + "; build anew, without gaps");
    }
    Scratch scratch;
    const std::span<std::uint32_t> sizes = scratch.take<std::uint32_t>(nodes.size() / 2);
    count_pairs(nodes, sizes);
    const std::vector<std::uint32_t> roots = cut(nodes, sizes);
    visits_ = scratch_.take<Visit>(subtree_begins_.back());
    group_subtrees();
    tbb::parallel_for(std::size_t{0}, chunk_count(), [&](std::size_t chunk) {
        std::vector<std::uint32_t> stack;
        for (std::size_t i = chunk_begins_[chunk]; i < chunk_begins_[chunk + 1]; ++i) {
            Visit* target = &visits_[subtree_begins_[i]];
            stack.push_back(roots[i]);
            while (!stack.empty()) {
                const Node& node = nodes[stack.back()];
                stack.pop_back();
                *target++ = visit_to_children(nodes, node);
                push_inner_children(nodes, node, stack);
            }
        }
    });
}

RefitPlan::Chunk RefitPlan::chunk(std::size_t index) const noexcept {
    const std::size_t first = chunk_begins_[index];
    const std::size_t end = chunk_begins_[index + 1];
    const std::size_t begin = subtree_begins_[first];
    return {visits_.subspan(begin, subtree_begins_[end] - begin), first, end - first};
}

std::vector<std::uint32_t> RefitPlan::cut(std::span<const Node> nodes, std::span<const std::uint32_t> sizes) {
    std::vector<std::uint32_t> roots;
    std::vector<std::uint32_t> stack{0};
    subtree_begins_.push_back(0);
    while (!stack.empty()) {
        const std::uint32_t root = stack.back();
        const Node& node = nodes[root];
        stack.pop_back();
        const std::uint32_t size = sizes[node.first / 2];
        if (size <= kSubtreePairs) {
            roots.push_back(root);
            subtree_begins_.push_back(subtree_begins_.back() + size);
            above_.push_back(Visit::of_subtree());
        } else {
            above_.push_back(visit_to_children(nodes, node));
            push_inner_children(nodes, node, stack);
        }
    }
    return roots;
}

void RefitPlan::group_subtrees() {
    chunk_begins_.push_back(0);
    for (std::size_t i = 1; i < subtree_begins_.size(); ++i) {
        const bool is_full = subtree_begins_[i] - subtree_begins_[chunk_begins_.back()] >= kSubtreePairs;
        if (is_full || i + 1 == subtree_begins_.size()) chunk_begins_.push_back(i);
    }
}

}  // namespace clbvh::optimizer
