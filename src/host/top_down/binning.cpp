#include "host/top_down/binning.hpp"

#include <limits>

#include "core/simd/box8.hpp"
#include "host/top_down/binning_loops.hpp"

namespace clbvh::host {
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
    // Vector by vector: GCC 12 fills a whole row by a string instruction, which is slow to start.
    const Float4 corner = Float4::load(kEmptyRow.boxes[0]);
    for (std::uint32_t bin = 0; bin < bin_count; ++bin) {
        BinRow& row = rows_[bin];
        for (auto& box : row.boxes) {
            corner.store(box);
            corner.store(box + 4);
        }
        for (auto& count : row.counts)
            count = 0;
    }
}

void BinSet::add(std::span<const Reference> references, const Binning& binning) noexcept {
    binning_loops().add_references(rows_.data(), references, binning);
}

void BinSet::add(const BinSet& other) noexcept {
    using Box = simd::Box8<simd::baseline::Set>;
    for (std::uint32_t bin = 0; bin < bin_count_; ++bin) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            float* const target = rows_[bin].boxes[axis];
            Box merged = Box::load(target);
            merged.merge(Box::load(other.rows_[bin].boxes[axis]));
            merged.store(target);
            rows_[bin].counts[axis] += other.rows_[bin].counts[axis];
        }
    }
}

BinnedSplit BinSet::find_split(float unit) const noexcept {
    return binning_loops().find_border(rows_.data(), bin_count_, unit);
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
    return binning_loops().find_border_of_few(references, binning, unit);
}

}  // namespace clbvh::host
