#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "clbvh/core/bvh.hpp"

namespace clbvh {

[[nodiscard]] inline std::string name_node(std::size_t node) {
    return "node " + std::to_string(node);
}

/// A walk over the nodes that the root leads to, parents before children, first child first, which proves on its way
/// that they form a tree: every pair of children is there, starts at an even index and has one parent. It ends after as
/// many steps as there are nodes, whatever they hold. Boxes are taken as they are.
///
///     TreeWalk walk(bvh);
///     while (walk.next()) use(walk.node(), walk.depth());
///     if (walk.failed()) throw Error(ErrorCode::invalid_input, walk.fault());
class TreeWalk {
public:
    /// Proves also that the leaves' ranges lie within the primitive ids.
    explicit TreeWalk(const Bvh& bvh) : TreeWalk(bvh.nodes, bvh.primitive_ids.size()) {}

    /// Takes leaves as they are.
    explicit TreeWalk(std::span<const Node> nodes) : TreeWalk(nodes, std::numeric_limits<std::uint64_t>::max()) {}

    /// Moves to the next node. False at the end, and at a node with a fault.
    [[nodiscard]] bool next() {
        if (open_.empty()) return false;
        here_ = open_.back();
        open_.pop_back();
        const Node& node = nodes_[here_.node];
        if (node.is_leaf()) return std::uint64_t{node.first} + node.count <= id_count_ || fail(range_fault());
        const std::size_t first = node.first;
        if (first % 2 != 0) return fail(children_fault("start at an odd index"));
        if (first + 1 >= nodes_.size()) {
            return fail(children_fault("are out of range (there are " + std::to_string(nodes_.size()) + " nodes)"));
        }
        if (pair_reached_[first / 2]) return fail(children_fault("have another parent, or are the root"));
        pair_reached_[first / 2] = true;
        open_.push_back({node.first + 1, here_.depth + 1});
        open_.push_back({node.first, here_.depth + 1});
        return true;
    }

    /// Of the node that next() moved to. Both children of an inner one are in range.
    [[nodiscard]] std::uint32_t node() const noexcept { return here_.node; }
    [[nodiscard]] std::uint32_t depth() const noexcept { return here_.depth; }

    [[nodiscard]] bool failed() const noexcept { return !fault_.empty(); }
    /// Names the first node with a fault, and says what is wrong with it; empty where nothing is.
    [[nodiscard]] const std::string& fault() const noexcept { return fault_; }

    /// Whether nodes 2 * p and 2 * p + 1 have been met as a pair, for each p; the root's pair counts as met.
    [[nodiscard]] std::vector<bool> take_pairs() && noexcept { return std::move(pair_reached_); }

private:
    struct Visit {
        std::uint32_t node;
        std::uint32_t depth;
    };

    TreeWalk(std::span<const Node> nodes, std::uint64_t id_count)
        : nodes_(nodes), id_count_(id_count), pair_reached_((nodes.size() + 1) / 2, false) {
        if (nodes.empty()) return;
        pair_reached_[0] = true;
        open_.push_back({0, 0});
    }

    [[nodiscard]] std::string range_fault() const {
        const Node& leaf = nodes_[here_.node];
        return name_node(here_.node) + ": its primitive range ends at " +
               std::to_string(std::uint64_t{leaf.first} + leaf.count) + ", but there are " + std::to_string(id_count_) +
               " primitive ids";
    }

    [[nodiscard]] std::string children_fault(const std::string& what) const {
        const std::size_t first = nodes_[here_.node].first;
        return name_node(here_.node) + ": its children " + std::to_string(first) + " and " + std::to_string(first + 1) +
               " " + what;
    }

    bool fail(std::string fault) {
        fault_ = std::move(fault);
        open_.clear();
        return false;
    }

    std::span<const Node> nodes_;
    std::uint64_t id_count_;
    std::vector<bool> pair_reached_;
    std::vector<Visit> open_;
    Visit here_{0, 0};
    std::string fault_;
};

}  // namespace clbvh
