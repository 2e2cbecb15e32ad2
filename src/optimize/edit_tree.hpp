#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "core/simd/box4.hpp"

namespace clbvh::optimizer {

/// The nodes of a finished tree with parent links, for changes in place. A subtree is what its root's slot holds:
/// subtrees change places by an exchange of two slots. Siblings stay at 2s and 2s + 1, and no slot is ever freed or
/// taken.
class EditTree {
public:
    static constexpr std::uint32_t kUnused = ~0u;

    /// Finds the nodes from the root, in parallel; slots that no node uses are left alone.
    explicit EditTree(std::span<Node> nodes);

    [[nodiscard]] Node& operator[](std::uint32_t slot) noexcept { return nodes_[slot]; }
    [[nodiscard]] const Node& operator[](std::uint32_t slot) const noexcept { return nodes_[slot]; }
    [[nodiscard]] std::span<const Node> nodes() const noexcept { return nodes_; }
    [[nodiscard]] std::uint32_t slot_count() const noexcept { return static_cast<std::uint32_t>(nodes_.size()); }

    [[nodiscard]] static constexpr std::uint32_t sibling(std::uint32_t slot) noexcept { return slot ^ 1; }
    /// Of a slot other than the root's; kUnused where no node uses the slot.
    [[nodiscard]] std::uint32_t parent(std::uint32_t slot) const noexcept { return parents_[slot / 2]; }
    [[nodiscard]] Box4 box(std::uint32_t slot) const noexcept {
        const Node& node = nodes_[slot];
        return {Float4::load(node.lower).without_w(), Float4::load(node.upper).without_w()};
    }

    /// Tells the children of what stands in `slot` now that it does.
    void adopt(std::uint32_t slot) noexcept {
        if (!nodes_[slot].is_leaf()) parents_[nodes_[slot].first / 2] = slot;
    }
    /// Exchanges two subtrees, neither of which holds the other. Boxes above them are not brought up to date.
    void exchange(std::uint32_t a, std::uint32_t b) noexcept {
        std::swap(nodes_[a], nodes_[b]);
        adopt(a);
        adopt(b);
    }
    /// The sum of the inner nodes' half areas: all of the SAH cost that moving subtrees can change. The same on any
    /// number of threads.
    [[nodiscard]] double inner_half_area() const;

    /// Gives an inner node the union of its children's boxes; true where that changes it.
    bool refit(std::uint32_t slot) noexcept;

private:
    std::span<Node> nodes_;
    std::vector<std::uint32_t> parents_;  // of sibling pair p
};

}  // namespace clbvh::optimizer
