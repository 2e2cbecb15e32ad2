#pragma once

#include <cstdint>
#include <span>

#include "core/scratch.hpp"
#include "host/build/emit_tree.hpp"
#include "host/build/reference.hpp"

namespace clbvh::host {

/// Beyond this depth builders that follow the surface area heuristic halve ranges, so that no input makes a tree that
/// is much deeper.
inline constexpr std::uint32_t kMaxSahDepth = 256;

/// The growing tree of a builder that splits a range of positions at each inner node. Pair p, which is nodes 2p and
/// 2p + 1, takes the children of a node that is split at position p: every position from 1 to n - 1 is a border once at
/// most, so tasks share no counter, and every number of threads gives the same numbering. A subtree over the positions
/// from b to e that one task builds alone may as well take the pairs b + 1 to e - 1 in the order in which it comes by
/// them, which is the order in which emit_tree() reads.
class RangeTree {
public:
    RangeTree(Scratch& scratch, std::size_t count)
        : nodes_(scratch.take<Node>(2 * count)),
          extents_(scratch.take<Extent>(count)),
          primitive_ids_(scratch.take<std::uint32_t>(count)) {}

    /// Slot of the left node of a pair; the right one follows.
    [[nodiscard]] static constexpr std::uint32_t left_child(std::uint32_t pair) noexcept { return 2 * pair; }

    /// Makes a leaf of `references`, which begin at position `begin`. Its ids ascend, so that they do not depend on how
    /// the references came here.
    Extent set_leaf(std::uint32_t slot, const Box4& box, std::uint32_t begin, std::span<const Reference> references);

    /// Makes an inner node over `pair`, both of whose subtrees are finished.
    Extent set_inner(std::uint32_t slot, const Box4& box, std::uint32_t pair, const Extent& left,
                     const Extent& right) noexcept {
        nodes_[slot] = make_node(box, left_child(pair), 0);
        return extents_[pair] = {left.pairs + right.pairs + 1, left.primitives + right.primitives};
    }

    /// The union of the boxes of a pair's nodes, both of which are finished.
    [[nodiscard]] Box4 box_of(std::uint32_t pair) const noexcept {
        Box4 box = Box4::of(nodes_[left_child(pair)]);
        box.merge(Box4::of(nodes_[left_child(pair) + 1]));
        return box;
    }

    [[nodiscard]] TreeSlots slots() const noexcept { return {nodes_, extents_, primitive_ids_}; }

private:
    std::span<Node> nodes_;
    std::span<Extent> extents_;
    std::span<std::uint32_t> primitive_ids_;
};

inline Extent RangeTree::set_leaf(std::uint32_t slot, const Box4& box, std::uint32_t begin,
                                  std::span<const Reference> references) {
    const auto count = static_cast<std::uint32_t>(references.size());
    std::uint32_t* const ids = primitive_ids_.data() + begin;
    for (std::uint32_t i = 0; i < count; ++i) {
        std::uint32_t place = i;
        for (; place > 0 && ids[place - 1] > references[i].primitive; --place)
            ids[place] = ids[place - 1];
        ids[place] = references[i].primitive;
    }
    nodes_[slot] = make_node(box, begin, count);
    return {0, count};
}

}  // namespace clbvh::host
