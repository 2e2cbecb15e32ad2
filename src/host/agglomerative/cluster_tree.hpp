#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/scratch.hpp"
#include "host/build/reference.hpp"

namespace clbvh::host {

/// A search tree over boxes that stand in numbered slots, each slot taken or empty: it finds the slot whose box has the
/// smallest union with a given one. The tree is implicit: a node of level k covers 4^k slots, aligned, and knows a
/// lower bound for the union of any box with any of its own. It is as good as the order of the slots is.
class ClusterTree {
public:
    /// A slot and the half area of its box's union with the box that was searched for.
    struct Neighbour {
        float distance = std::numeric_limits<float>::max();
        std::uint32_t slot = std::numeric_limits<std::uint32_t>::max();
    };

    /// Takes memory for up to `capacity` slots.
    ClusterTree(Scratch& scratch, std::size_t capacity);

    /// Fills slots 0 .. boxes.size() - 1, leaves no others, and refits.
    void assign(std::span<const Reference> boxes);

    /// Changes one slot. Until a refit the tree must not be searched.
    void set(std::uint32_t slot, const Reference& box) noexcept;
    void clear(std::uint32_t slot) noexcept;

    /// Makes the tree right after any number of changes.
    void refit();
    /// Makes the tree right after a change of `slot` alone.
    void refit_above(std::uint32_t slot) noexcept;

    /// The nearest of the other slots to the one that holds `box`; there must be one. Of equal distances the slot j
    /// with the smallest `slot` XOR j is nearest: so the closest of all pairs is always mutual, and equal boxes pair up
    /// all at once.
    [[nodiscard]] Neighbour find_nearest(std::uint32_t slot, const Reference& box) const noexcept;

private:
    /// Boxes of four slots.
    struct Leaf {
        float lower[3][4];
        float upper[3][4];
    };
    /// Bounds of four nodes: what holds for each box below them.
    struct Group {
        float most_lower[3][4];    ///< No lower corner is above.
        float least_upper[3][4];   ///< No upper corner is below.
        float least_extent[3][4];  ///< No box is narrower.
        float least_area[4];       ///< No half area is smaller.
    };
    class Search;

    void refit_leaf(std::uint32_t leaf) noexcept;
    void refit_group(std::size_t level, std::uint32_t group) noexcept;

    std::span<Leaf> all_leaves_;
    std::span<Group> all_groups_;
    std::span<Leaf> leaves_;                ///< Level 0: leaf v holds slots 4v .. 4v + 3.
    std::vector<std::span<Group>> levels_;  ///< levels_[k - 1], group g bounds the nodes 4g .. 4g + 3 of level k.
};

}  // namespace clbvh::host
