#pragma once

#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "clbvh/core/bvh.hpp"

// Layouts whose nodes are in depth-first order: which part of them each task writes.
namespace clbvh::layout {

/// A node of the top of the tree, or a whole subtree below the top.
struct Part {
    std::uint32_t node;   ///< Of the binary tree.
    std::uint32_t depth;  ///< Edges from the root to it.
    bool is_subtree;      ///< Else an inner node whose children are parts themselves.

    // With all that is below the node:
    std::uint32_t first_node = 0;  ///< Number of the node in depth-first order.
    std::uint32_t node_count = 0;
    std::uint32_t first_id = 0;  ///< Place of its first primitive id, leaf after leaf.
    std::uint32_t id_count = 0;
    std::uint32_t nodes_of_first_child = 0;  ///< The child and all below it; of nodes of the top only.
};

/// All parts of a tree.
struct TreeParts {
    std::vector<Part> parts;  ///< In depth-first order; the first is the root's.
    std::uint32_t depth = 0;  ///< Edges on the longest path from the root.
};

/// Walks over the nodes that the root leads to, in parallel; there is one at least. Takes any nodes whatever, reads
/// nothing out of range, and ends after about as many steps as there are nodes.
/// Nothing where these nodes form no tree, or leaves have no ids. Some trees with more than one parent for a node pass,
/// if all of it together is no more than there are nodes and ids: as many of `pairs`, where that is not null, are then
/// 1 as there are pairs with a parent, fewer than inner nodes were met. It is all zeros before, one for each two nodes.
[[nodiscard]] std::optional<TreeParts> find_parts(const Bvh& bvh, std::atomic<std::uint8_t>* pairs = nullptr);

/// The parts of a tree. They depend on the tree alone, not on the number of threads.
class DepthFirst {
public:
    /// Throws Error(invalid_input) naming the first offender where find_parts finds none.
    explicit DepthFirst(const Bvh& bvh);

    [[nodiscard]] std::uint32_t node_count() const noexcept { return tree_.parts[0].node_count; }
    [[nodiscard]] std::uint32_t id_count() const noexcept { return tree_.parts[0].id_count; }
    [[nodiscard]] std::uint32_t depth() const noexcept { return tree_.depth; }

    /// Calls `write(part)` for each part, in parallel.
    template <typename Write>
    void for_each_part(const Write& write) const {
        tbb::parallel_for(
            std::size_t{0}, tree_.parts.size(), [&](std::size_t i) { write(tree_.parts[i]); },
            tbb::simple_partitioner{});
    }

private:
    TreeParts tree_;
};

}  // namespace clbvh::layout
