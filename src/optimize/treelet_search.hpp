#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "clbvh/core/bvh.hpp"
#include "core/simd/box4.hpp"

namespace clbvh::optimizer {

/// The best binary tree over a few boxes, by dynamic programming over all subsets (Karras, Aila 2013, section 3.2).
/// A subset is a number whose bit i stands for box i.
class TreeletSearch {
public:
    static constexpr std::uint32_t kMostLeaves = 8;

    /// Finds, for every subset, the tree whose inner nodes' areas have the least sum.
    void run(std::span<const Box4> boxes) noexcept;

    /// The sum for all boxes, their union's own area included.
    [[nodiscard]] float least_area() const noexcept { return costs_[all_]; }
    /// One of the two parts into which the best tree cuts a subset of two or more; the rest is the other.
    [[nodiscard]] std::uint32_t part_of(std::uint32_t subset) const noexcept { return parts_[subset]; }
    /// All boxes.
    [[nodiscard]] std::uint32_t all() const noexcept { return all_; }

private:
    static constexpr std::uint32_t kSubsets = 1u << kMostLeaves;

    std::uint32_t all_ = 0;
    std::array<Box4, kSubsets> boxes_;
    std::array<float, kSubsets> costs_;
    std::array<std::uint8_t, kSubsets> parts_;
};

}  // namespace clbvh::optimizer
