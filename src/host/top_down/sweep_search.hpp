#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <tuple>

#include "host/build/reference.hpp"

namespace clbvh::host {

/// A range of references in the orders of their centroids along the three axes.
struct SortedRange {
    const Reference* references;
    std::array<const std::uint32_t*, 3> orders;  ///< Indices of the range's references, each order begins here.
    std::uint32_t count;
    float unit;  ///< Weight of one reference, a power of two: small enough that no cost overflows.

    [[nodiscard]] Box4 box(std::size_t axis, std::uint32_t position) const noexcept {
        return Box4::of(references[orders[axis][position]]);
    }
    [[nodiscard]] float weight(std::uint32_t number) const noexcept { return static_cast<float>(number) * unit; }
};

/// The first `position` references along `axis` go left, the others right.
struct SweepSplit {
    float cost = std::numeric_limits<float>::infinity();  ///< Half area times weight, left and right together.
    std::uint32_t axis = 3;                               ///< 3: nothing has been evaluated yet.
    std::uint32_t position = 0;

    /// Total order of the splits of `count` references. Of equal costs the more balanced split is better, so that
    /// boxes that cost the same wherever they are parted get a tree of logarithmic depth; then the first one.
    [[nodiscard]] bool is_better_than(const SweepSplit& other, std::uint32_t count) const noexcept {
        if (cost != other.cost) return cost < other.cost;
        const auto imbalance = [count](const SweepSplit& split) {
            return std::abs(2 * std::int64_t{split.position} - std::int64_t{count});
        };
        return std::tuple(imbalance(*this), axis, position) < std::tuple(imbalance(other), other.axis, other.position);
    }
};

/// The best split of a range, and the range's box.
struct SweepResult {
    SweepSplit split;
    Box4 box;
};

/// The best of all splits along all axes, of at least two references. Large ranges are searched by many threads.
[[nodiscard]] SweepResult find_sweep_split(const SortedRange& range);

}  // namespace clbvh::host
