#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "host/build/reference.hpp"
#include "host/top_down/config_rules.hpp"

namespace clbvh::host {

/// Maps centroids to equal bins along each axis of their bounds.
class Binning {
public:
    /// `centroid_bounds` are those of doubled centroids. `longest_axis_only` leaves one bin to the other axes.
    Binning(const Box4& centroid_bounds, std::uint32_t bin_count, bool longest_axis_only) noexcept;

    /// Bins of one reference along x, y and z, into `bins`, which takes four.
    CLBVH_ALWAYS_INLINE void bins_of(const Reference& reference, std::int32_t* bins) const noexcept {
        const Float4 offset = Box4::of(reference).doubled_centroid() - base_;
        min(offset * scale_, last_).truncate(bins);
    }

private:
    Float4 base_;
    Float4 scale_;  ///< 0 along an axis that has one bin only.
    Float4 last_;
};

/// A border between bins: references whose bin along `axis` is below `bin` go left.
struct BinnedSplit {
    float cost = std::numeric_limits<float>::infinity();  ///< Half area times weight, left and right together.
    std::uint32_t axis = 3;                               ///< 3: there is no border between two references.
    std::uint32_t bin = 0;

    [[nodiscard]] bool found() const noexcept { return axis < 3; }
};

/// One bin of each axis: what lies in it.
struct alignas(64) BinRow {
    float boxes[3][8];  ///< Along x, y and z: lower corner, and upper corner with its sign turned; a lane unused each.
    std::int32_t counts[4];  ///< Along x, y and z; the fourth is 0.
};

/// References counted and bounded, bin by bin, along all axes.
class BinSet {
public:
    explicit BinSet(std::uint32_t bin_count) noexcept;

    void add(std::span<const Reference> references, const Binning& binning) noexcept;
    void add(const BinSet& other) noexcept;

    /// The cheapest border, where each reference weighs `unit`; the first one along the first axis among equals.
    [[nodiscard]] BinnedSplit find_split(float unit = 1.0f) const noexcept;

    /// The boxes of what goes left and of what goes right.
    [[nodiscard]] std::array<Box4, 2> boxes_of(const BinnedSplit& split) const noexcept;

    /// How many references go left.
    [[nodiscard]] std::uint32_t count_left_of(const BinnedSplit& split) const noexcept;

private:
    std::uint32_t bin_count_;
    std::array<BinRow, kMaxBinCount> rows_;
};

/// As BinSet, for few references: the same split, in time that does not depend on the number of bins.
inline constexpr std::size_t kFewReferences = 16;
[[nodiscard]] BinnedSplit find_split_of_few(std::span<const Reference> references, const Binning& binning,
                                            float unit = 1.0f) noexcept;

}  // namespace clbvh::host
