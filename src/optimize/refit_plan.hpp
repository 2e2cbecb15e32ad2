#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"
#include "core/scratch.hpp"

namespace clbvh::optimizer {

/// The sibling pairs of a tree in an order in which each comes after those below it, cut so that threads can work on
/// it: whole subtrees in chunks that do not depend on each other, then what is above them.
///
/// Lists are to be read from the back, and then need no more than a stack: the result of a pair's right child, where
/// that is an inner node, was pushed before that of its left one, and nothing since.
class RefitPlan {
public:
    /// Pairs are numbered in 30 bits, of which the last number means a subtree. Trees without gaps fit.
    static constexpr std::uint64_t kMostSlots = 2 * kMaxPrimitives;

    /// Finds the order in parallel; O(n) time. The tree is one that validate() accepts, and its root an inner node.
    /// Throws Error(unsupported) beyond kMostSlots.
    explicit RefitPlan(std::span<const Node> nodes);

    /// One pair: its number (nodes 2p and 2p + 1), and which of the two are leaves.
    class Visit {
    public:
        Visit(std::uint32_t pair, bool left_is_leaf, bool right_is_leaf) noexcept
            : bits_(pair << 2 | (right_is_leaf ? 2u : 0u) | (left_is_leaf ? 1u : 0u)) {}
        /// In the list above chunks: take the result of the last subtree that was not taken yet.
        [[nodiscard]] static Visit of_subtree() noexcept { return Visit(kSubtree); }

        [[nodiscard]] std::uint32_t pair() const noexcept { return bits_ >> 2; }
        [[nodiscard]] bool is_leaf(std::uint32_t side) const noexcept { return (bits_ >> side & 1u) != 0; }
        [[nodiscard]] bool is_subtree() const noexcept { return bits_ == kSubtree; }

    private:
        static constexpr std::uint32_t kSubtree = ~0u;  // pairs stay below 2^30 - 1
        explicit Visit(std::uint32_t bits) noexcept : bits_(bits) {}
        std::uint32_t bits_;
    };

    struct Chunk {
        std::span<const Visit> visits;
        std::size_t first_subtree;  ///< Its subtrees are this one and those up to the next chunk's.
        std::size_t subtree_count;
    };

    [[nodiscard]] std::size_t chunk_count() const noexcept { return chunk_begins_.size() - 1; }
    [[nodiscard]] Chunk chunk(std::size_t index) const noexcept;
    [[nodiscard]] std::size_t subtree_count() const noexcept { return subtree_begins_.size() - 1; }
    [[nodiscard]] std::span<const Visit> above() const noexcept { return above_; }

private:
    /// Writes what is above the subtrees, and where each of these begins; returns their roots.
    std::vector<std::uint32_t> cut(std::span<const Node> nodes, std::span<const std::uint32_t> sizes);
    void group_subtrees();

    Scratch scratch_;
    std::span<Visit> visits_;                  // of subtrees, one after the other
    std::vector<std::size_t> subtree_begins_;  // in visits_, and the end
    std::vector<std::size_t> chunk_begins_;    // in subtree_begins_, and the end
    std::vector<Visit> above_;
};

}  // namespace clbvh::optimizer
