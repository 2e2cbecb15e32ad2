#include "host/binning.hpp"

#include <limits>

namespace clbvh::host {

Binning::Binning(const Box4& centroid_bounds, std::uint32_t bin_count, bool longest_axis_only) noexcept
    : base_(centroid_bounds.lower), bin_count_(bin_count) {
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
        divides_[axis] = extent[axis] > 0.0f && quotient <= std::numeric_limits<float>::max();
        scale[axis] = divides_[axis] ? quotient : 0.0f;
    }
    scale_ = Float4::of(scale[0], scale[1], scale[2]);
    last_ = Float4::filled(static_cast<float>(bin_count - 1));
}

void BinSet::add(std::span<const Reference> references, const Binning& binning) noexcept {
    for (const Reference& reference : references) {
        std::int32_t bins[4];
        binning.bins_of(reference, bins);
        const Box4 box = Box4::of(reference);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto bin = static_cast<std::size_t>(bins[axis]);
            boxes_[axis][bin].merge(box);
            ++counts_[axis][bin];
        }
    }
}

void BinSet::add(const BinSet& other) noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t bin = 0; bin < bin_count_; ++bin) {
            boxes_[axis][bin].merge(other.boxes_[axis][bin]);
            counts_[axis][bin] += other.counts_[axis][bin];
        }
    }
}

BinnedSplit BinSet::find_split(const Binning& binning) const noexcept {
    BinnedSplit best;
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
        if (binning.divides(axis)) sweep_axis(axis, best);
    }
    return best;
}

void BinSet::sweep_axis(std::uint32_t axis, BinnedSplit& best) const noexcept {
    const auto& boxes = boxes_[axis];
    const auto& counts = counts_[axis];
    std::array<float, kMaxBinCount> right_costs;
    Box4 box;
    std::uint32_t count = 0;
    for (std::uint32_t bin = bin_count_ - 1; bin > 0; --bin) {
        box.merge(boxes[bin]);
        count += counts[bin];
        right_costs[bin] =
            count == 0 ? std::numeric_limits<float>::infinity() : box.half_area() * static_cast<float>(count);
    }
    box = Box4{};
    count = 0;
    for (std::uint32_t bin = 1; bin < bin_count_; ++bin) {
        box.merge(boxes[bin - 1]);
        count += counts[bin - 1];
        if (count == 0) continue;
        const float cost = box.half_area() * static_cast<float>(count) + right_costs[bin];
        if (cost < best.cost) best = {cost, axis, bin};
    }
}

BinnedSplit find_split_of_few(std::span<const Reference> references, const Binning& binning) noexcept {
    const std::size_t count = references.size();
    std::array<std::array<std::int32_t, 4>, kFewReferences> bins;
    for (std::size_t i = 0; i < count; ++i)
        binning.bins_of(references[i], bins[i].data());
    BinnedSplit best;
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
        if (!binning.divides(axis)) continue;
        // Bin above, place in `references` below.
        std::array<std::uint32_t, kFewReferences> order;
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t key = static_cast<std::uint32_t>(bins[i][axis]) << 8 | static_cast<std::uint32_t>(i);
            std::size_t place = i;
            for (; place > 0 && order[place - 1] > key; --place)
                order[place] = order[place - 1];
            order[place] = key;
        }
        std::array<float, kFewReferences> right_costs;
        Box4 box;
        for (std::size_t i = count - 1; i > 0; --i) {
            box.merge(Box4::of(references[order[i] & 0xff]));
            right_costs[i] = box.half_area() * static_cast<float>(count - i);
        }
        box = Box4{};
        for (std::size_t i = 1; i < count; ++i) {
            box.merge(Box4::of(references[order[i - 1] & 0xff]));
            const std::uint32_t bin_before = order[i - 1] >> 8;
            if (bin_before == order[i] >> 8) continue;
            const float cost = box.half_area() * static_cast<float>(i) + right_costs[i];
            if (cost < best.cost) best = {cost, axis, bin_before + 1};
        }
    }
    return best;
}

}  // namespace clbvh::host
