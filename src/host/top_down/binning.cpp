#include "host/top_down/binning.hpp"

#include <bit>
#include <limits>

#include "core/simd/box8.hpp"
#include "core/simd/prefetch.hpp"

namespace clbvh::host {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// References ahead of the one at work that are asked for: without it, what lies beyond the second cache takes three
/// times as long.
constexpr std::size_t kPrefetch = 64;

CLBVH_ALWAYS_INLINE void clear(BinRow& row) noexcept {
    constexpr BinRow empty{{{kInfinity, kInfinity, kInfinity, 0, kInfinity, kInfinity, kInfinity, 0},
                            {kInfinity, kInfinity, kInfinity, 0, kInfinity, kInfinity, kInfinity, 0},
                            {kInfinity, kInfinity, kInfinity, 0, kInfinity, kInfinity, kInfinity, 0}},
                           {0, 0, 0, 0}};
    row = empty;
}

template <typename Box>
CLBVH_ALWAYS_INLINE void merge_into(float* target, const Box& box) noexcept {
    Box merged = Box::load(target);
    merged.merge(box);
    merged.store(target);
}

template <typename Box>
CLBVH_ALWAYS_INLINE void add_to_row(BinRow* rows, std::int32_t bin, std::size_t axis, const Box& box) noexcept {
    BinRow& row = rows[bin];
    merge_into(row.boxes[axis], box);
    ++row.counts[axis];
}

template <typename Box>
CLBVH_ALWAYS_INLINE void add_references(BinRow* rows, std::span<const Reference> references,
                                        const Binning& binning) noexcept {
    for (std::size_t i = 0; i < references.size(); ++i) {
        prefetch(references.data() + i + kPrefetch);
        std::int32_t bins[4];
        binning.bins_of(references[i], bins);
        const Box box = Box::of(references[i]);
        add_to_row(rows, bins[0], 0, box);
        add_to_row(rows, bins[1], 1, box);
        add_to_row(rows, bins[2], 2, box);
    }
}

/// The boxes to one side of a border, along the three axes at once.
template <typename Box>
struct Sweep {
    Box x, y, z;
    Int4 count{};

    CLBVH_ALWAYS_INLINE explicit Sweep(const BinRow& row) noexcept
        : x(Box::load(row.boxes[0])),
          y(Box::load(row.boxes[1])),
          z(Box::load(row.boxes[2])),
          count(Int4::load(row.counts)) {}

    CLBVH_ALWAYS_INLINE void add(const BinRow& row) noexcept {
        x.merge(Box::load(row.boxes[0]));
        y.merge(Box::load(row.boxes[1]));
        z.merge(Box::load(row.boxes[2]));
        count = count + Int4::load(row.counts);
    }
    /// Not a number where nothing is on this side: infinite extents, of nothing.
    [[nodiscard]] CLBVH_ALWAYS_INLINE Float4 cost(Float4 unit) const noexcept {
        return half_areas_of_extents(x.negated_extents(), y.negated_extents(), z.negated_extents()) *
               (count.to_float() * unit);
    }
};

template <typename Box>
CLBVH_ALWAYS_INLINE BinnedSplit find_border(const BinRow* rows, std::uint32_t row_count, float unit) noexcept {
    const Float4 units = Float4::filled(unit);
    std::array<Float4, kMaxBinCount> right_costs;
    Sweep<Box> right(rows[row_count - 1]);
    for (std::uint32_t bin = row_count - 1; bin > 0; --bin) {
        right_costs[bin] = right.cost(units);
        right.add(rows[bin - 1]);
    }
    Float4 best_cost = Float4::filled(kInfinity);
    Float4 best_bin = Float4::filled(0.0f);
    Sweep<Box> left(rows[0]);
    for (std::uint32_t bin = 1; bin < row_count; ++bin) {
        const Float4 cost = left.cost(units) + right_costs[bin];
        best_bin = select_less(cost, best_cost, Float4::filled(static_cast<float>(bin)), best_bin);
        best_cost = select_less(cost, best_cost, cost, best_cost);
        left.add(rows[bin]);
    }
    float costs[4], bins[4];
    best_cost.store(costs);
    best_bin.store(bins);
    BinnedSplit best;
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
        if (costs[axis] < best.cost) best = {costs[axis], axis, static_cast<std::uint32_t>(bins[axis])};
    }
    return best;
}

/// Bins that hold something, in one bit each.
using BinMask = std::uint64_t;
static_assert(kMaxBinCount <= 64);

[[nodiscard]] CLBVH_ALWAYS_INLINE std::int32_t rank(BinMask occupied, std::int32_t bin) noexcept {
    return std::popcount(occupied & ((BinMask{1} << bin) - 1));
}

/// Only bins that hold something get a row.
template <typename Box>
CLBVH_ALWAYS_INLINE BinnedSplit find_border_of_few(std::span<const Reference> references, const Binning& binning,
                                                   float unit) noexcept {
    std::array<std::array<std::int32_t, 4>, kFewReferences> bins;
    std::array<BinMask, 3> occupied{};
    for (std::size_t i = 0; i < references.size(); ++i) {
        binning.bins_of(references[i], bins[i].data());
        for (std::size_t axis = 0; axis < 3; ++axis)
            occupied[axis] |= BinMask{1} << bins[i][axis];
    }
    const int row_count =
        std::max({std::popcount(occupied[0]), std::popcount(occupied[1]), std::popcount(occupied[2])});
    std::array<BinRow, kFewReferences> rows;
    for (int row = 0; row < row_count; ++row)
        clear(rows[static_cast<std::size_t>(row)]);
    for (std::size_t i = 0; i < references.size(); ++i) {
        const Box box = Box::of(references[i]);
        for (std::size_t axis = 0; axis < 3; ++axis)
            add_to_row(rows.data(), rank(occupied[axis], bins[i][axis]), axis, box);
    }
    BinnedSplit split = find_border<Box>(rows.data(), static_cast<std::uint32_t>(row_count), unit);
    if (!split.found()) return split;
    // From the number of occupied bins on the left to the bin behind the last of them.
    BinMask left = occupied[split.axis];
    for (std::uint32_t i = 1; i < split.bin; ++i)
        left &= left - 1;
    split.bin = static_cast<std::uint32_t>(std::countr_zero(left)) + 1;
    return split;
}

#if defined(CLBVH_HAS_AVX2_FUNCTIONS)
CLBVH_AVX2_FUNCTION void add_references_avx2(BinRow* rows, std::span<const Reference> references,
                                             const Binning& binning) noexcept {
    add_references<Box8Avx>(rows, references, binning);
}
CLBVH_AVX2_FUNCTION BinnedSplit find_border_avx2(const BinRow* rows, std::uint32_t row_count, float unit) noexcept {
    return find_border<Box8Avx>(rows, row_count, unit);
}
CLBVH_AVX2_FUNCTION BinnedSplit find_border_of_few_avx2(std::span<const Reference> references, const Binning& binning,
                                                        float unit) noexcept {
    return find_border_of_few<Box8Avx>(references, binning, unit);
}
#else
constexpr auto add_references_avx2 = add_references<Box8Pair>;
constexpr auto find_border_avx2 = find_border<Box8Pair>;
constexpr auto find_border_of_few_avx2 = find_border_of_few<Box8Pair>;
#endif

}  // namespace

Binning::Binning(const Box4& centroid_bounds, std::uint32_t bin_count, bool longest_axis_only) noexcept
    : base_(centroid_bounds.lower) {
    const Float4 extents = centroid_bounds.upper - centroid_bounds.lower;
    std::array<float, 3> extent{extents.x(), extents.y(), extents.z()};
    if (longest_axis_only) {
        const auto longest = std::max_element(extent.begin(), extent.end());
        for (auto other = extent.begin(); other != extent.end(); ++other) {
            if (other != longest) *other = 0.0f;
        }
    }
    std::array<float, 3> scale{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        // The quotient overflows where the extent is next to nothing: then all share one bin.
        const float quotient = static_cast<float>(bin_count) / extent[axis];
        const bool divides = extent[axis] > 0.0f && quotient <= std::numeric_limits<float>::max();
        scale[axis] = divides ? quotient : 0.0f;
    }
    scale_ = Float4::of(scale[0], scale[1], scale[2]);
    last_ = Float4::filled(static_cast<float>(bin_count - 1));
}

BinSet::BinSet(std::uint32_t bin_count) noexcept : bin_count_(bin_count) {
    for (std::uint32_t bin = 0; bin < bin_count; ++bin)
        clear(rows_[bin]);
}

void BinSet::add(std::span<const Reference> references, const Binning& binning) noexcept {
    (use_avx2 ? add_references_avx2 : add_references<Box8Pair>)(rows_.data(), references, binning);
}

void BinSet::add(const BinSet& other) noexcept {
    for (std::uint32_t bin = 0; bin < bin_count_; ++bin) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            merge_into(rows_[bin].boxes[axis], Box8Pair::load(other.rows_[bin].boxes[axis]));
            rows_[bin].counts[axis] += other.rows_[bin].counts[axis];
        }
    }
}

BinnedSplit BinSet::find_split(float unit) const noexcept {
    return (use_avx2 ? find_border_avx2 : find_border<Box8Pair>)(rows_.data(), bin_count_, unit);
}

std::array<Box4, 2> BinSet::boxes_of(const BinnedSplit& split) const noexcept {
    std::array<Box4, 2> boxes;
    for (std::uint32_t bin = 0; bin < bin_count_; ++bin) {
        const float* const box = rows_[bin].boxes[split.axis];
        boxes[bin < split.bin ? 0 : 1].merge(Box4{Float4::load(box), Float4::filled(0.0f) - Float4::load(box + 4)});
    }
    return boxes;
}

std::uint32_t BinSet::count_left_of(const BinnedSplit& split) const noexcept {
    std::int32_t count = 0;
    for (std::uint32_t bin = 0; bin < split.bin; ++bin)
        count += rows_[bin].counts[split.axis];
    return static_cast<std::uint32_t>(count);
}

BinnedSplit find_split_of_few(std::span<const Reference> references, const Binning& binning, float unit) noexcept {
    return (use_avx2 ? find_border_of_few_avx2 : find_border_of_few<Box8Pair>)(references, binning, unit);
}

}  // namespace clbvh::host
