#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>

#include "core/check_field.hpp"
#include "host/reference.hpp"

namespace clbvh::host {

/// Maps centroids to equal bins along each axis of their bounds.
class Binning {
public:
    /// `centroid_bounds` are those of doubled centroids. `longest_axis_only` leaves one bin to the other axes.
    Binning(const Box4& centroid_bounds, std::uint32_t bin_count, bool longest_axis_only) noexcept;

    /// Bins of one reference along x, y and z, into `bins`, which takes four.
    void bins_of(const Reference& reference, std::int32_t* bins) const noexcept {
        const Float4 offset = Box4::of(reference).doubled_centroid() - base_;
        min(offset * scale_, last_).truncate(bins);
    }

    /// False along an axis that has one bin only.
    [[nodiscard]] bool divides(std::size_t axis) const noexcept { return divides_[axis]; }
    [[nodiscard]] std::uint32_t bin_count() const noexcept { return bin_count_; }

private:
    Float4 base_;
    Float4 scale_;
    Float4 last_;
    std::uint32_t bin_count_;
    std::array<bool, 3> divides_;
};

/// A border between bins: references whose bin along `axis` is below `bin` go left.
struct BinnedSplit {
    float cost = std::numeric_limits<float>::infinity();  ///< Half area times references, left and right together.
    std::uint32_t axis = 3;                               ///< 3: there is no border between two references.
    std::uint32_t bin = 0;

    [[nodiscard]] bool found() const noexcept { return axis < 3; }
};

/// References counted and bounded, bin by bin, along all axes.
class BinSet {
public:
    explicit BinSet(std::uint32_t bin_count) noexcept : bin_count_(bin_count) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            std::fill_n(boxes_[axis].begin(), bin_count, Box4{});
            std::fill_n(counts_[axis].begin(), bin_count, 0u);
        }
    }

    void add(std::span<const Reference> references, const Binning& binning) noexcept;
    void add(const BinSet& other) noexcept;

    /// The cheapest border; the first one along the first axis among equals.
    [[nodiscard]] BinnedSplit find_split(const Binning& binning) const noexcept;

    /// How many references go left.
    [[nodiscard]] std::uint32_t count_left_of(const BinnedSplit& split) const noexcept {
        const auto first = counts_[split.axis].begin();
        return std::accumulate(first, first + split.bin, 0u);
    }

private:
    void sweep_axis(std::uint32_t axis, BinnedSplit& best) const noexcept;

    std::uint32_t bin_count_;
    std::array<std::array<Box4, kMaxBinCount>, 3> boxes_;
    std::array<std::array<std::uint32_t, kMaxBinCount>, 3> counts_;
};

/// As BinSet::find_split, for few references: the same split, in time that does not depend on the number of bins.
inline constexpr std::size_t kFewReferences = 16;
[[nodiscard]] BinnedSplit find_split_of_few(std::span<const Reference> references, const Binning& binning) noexcept;

}  // namespace clbvh::host
