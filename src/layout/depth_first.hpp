#pragma once

#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#include <cstddef>
#include <cstdint>
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

/// The parts of a tree. They depend on the tree alone, not on the number of threads.
class DepthFirst {
public:
    /// Takes any nodes whatever: where those that the root leads to form no tree, or leaves have no ids, throws
    /// Error(invalid_input) naming the first offender. Some trees with more than one parent for a node pass, if all of
    /// it together is no more than there are nodes and ids.
    explicit DepthFirst(const Bvh& bvh);

    [[nodiscard]] std::uint32_t node_count() const noexcept { return node_count_; }
    [[nodiscard]] std::uint32_t id_count() const noexcept { return id_count_; }
    [[nodiscard]] std::uint32_t depth() const noexcept { return depth_; }

    /// Calls `write(part)` for each part, in parallel.
    template <typename Write>
    void for_each_part(const Write& write) const {
        tbb::parallel_for(
            std::size_t{0}, parts_.size(), [&](std::size_t i) { write(parts_[i]); }, tbb::simple_partitioner{});
    }

private:
    std::vector<Part> parts_;  ///< In depth-first order.
    std::uint32_t node_count_ = 0;
    std::uint32_t id_count_ = 0;
    std::uint32_t depth_ = 0;
};

}  // namespace clbvh::layout
