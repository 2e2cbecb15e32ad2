#include "host/top_down/sbvh_binning.hpp"

#include <algorithm>
#include <utility>

namespace clbvh::host {

SpatialBinning::SpatialBinning(const Box4& box, std::uint32_t bin_count) noexcept
    : base_(box.lower), bin_count_(bin_count), unit_(cost_unit(box.half_area())) {
    const Float4 extents = box.upper - box.lower;
    const std::array<float, 3> extent{extents.x(), extents.y(), extents.z()};
    lower_ = {box.lower.x(), box.lower.y(), box.lower.z()};
    std::array<float, 3> scale{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        // The quotient overflows where the extent is next to nothing: then all share one bin.
        const float quotient = static_cast<float>(bin_count) / extent[axis];
        const bool divides = extent[axis] > 0.0f && quotient <= std::numeric_limits<float>::max();
        scale[axis] = divides ? quotient : 0.0f;
        step_[axis] = divides ? extent[axis] / static_cast<float>(bin_count) : 0.0f;
    }
    scale_ = Float4::of(scale[0], scale[1], scale[2]);
    last_ = Float4::filled(static_cast<float>(bin_count - 1));
}

void SpatialBinning::bins_around(Float4 point, std::int32_t* bins) const noexcept {
    const Float4 one = Float4::filled(1.0f);
    const Float4 behind_last = last_ + one;
    // Shifted by one, so that rounding towards zero is rounding down.
    const Float4 shifted = max(min((point - base_) * scale_, behind_last) + one, Float4::filled(0.0f));
    shifted.truncate(bins);
    for (std::size_t axis = 0; axis < 3; ++axis)
        --bins[axis];
}

SpatialBinSet::SpatialBinSet(std::uint32_t bin_count) noexcept : bin_count_(bin_count) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        std::for_each_n(boxes_[axis].begin(), bin_count, [](BoxSlot& slot) { slot.clear(); });
        std::fill_n(entries_[axis].begin(), bin_count, 0u);
        std::fill_n(exits_[axis].begin(), bin_count, 0u);
    }
}

void SpatialBinSet::add(const MeshView* mesh, std::span<const Reference> references,
                        const SpatialBinning& binning) noexcept {
    for (const Reference& reference : references) {
        const Box4 box = Box4::of(reference);
        Span span;
        binning.bins_of(box.lower.without_w(), span.first);
        binning.bins_of(box.upper.without_w(), span.last);
        bool straddles = false;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto first = static_cast<std::size_t>(span.first[axis]);
            const auto last = static_cast<std::size_t>(span.last[axis]);
            ++entries_[axis][first];
            ++exits_[axis][last];
            if (first == last) {
                boxes_[axis][first].merge(box);
            } else {
                straddles = true;
            }
        }
        if (straddles && mesh != nullptr) add_parts(CutTriangle(*mesh, reference.primitive), box, span, binning);
        if (straddles && mesh == nullptr) add_box_parts(box, span, binning);
    }
}

void SpatialBinSet::add_parts(const CutTriangle& triangle, const Box4& box, const Span& span,
                              const SpatialBinning& binning) noexcept {
    std::int32_t corner_bins[3][4];
    for (std::size_t i = 0; i < 3; ++i)
        binning.bins_around(triangle.corner(i), corner_bins[i]);
    std::array<BoxSlot, kMaxBinCount> parts;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int32_t first = span.first[axis];
        const std::int32_t last = span.last[axis];
        if (first == last) continue;
        const auto part = [&](std::int32_t bin) -> BoxSlot& { return parts[static_cast<std::size_t>(bin - first)]; };
        std::for_each(&part(first), &part(last) + 1, [](BoxSlot& slot) { slot.clear(); });
        for (std::size_t from = 0; from < 3; ++from) {
            const std::size_t to = (from + 1) % 3;
            const std::int32_t bin = corner_bins[from][axis];
            const auto [low, high] = std::minmax(bin, corner_bins[to][axis]);
            if (first <= bin && bin <= last) part(bin).merge(triangle.corner(from));
            const std::int32_t end = std::min(high, last + 1);
            std::int32_t border = std::max(low + 1, first);
            if (border > end) continue;
            const CutEdge edge(triangle, from, to, axis);
            for (; border <= end; ++border) {
                const Float4 point = edge.cross(binning.plane(axis, static_cast<std::uint32_t>(border)));
                if (border > first) part(border - 1).merge(point);
                if (border <= last) part(border).merge(point);
            }
        }
        for (std::int32_t bin = first; bin <= last; ++bin) {
            const Box4 inside = intersect(part(bin).box(), box);
            if (has_point(inside)) boxes_[axis][static_cast<std::size_t>(bin)].merge(inside);
        }
    }
}

void SpatialBinSet::add_box_parts(const Box4& box, const Span& span, const SpatialBinning& binning) noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (span.first[axis] == span.last[axis]) continue;
        const auto end = static_cast<std::uint32_t>(span.last[axis]) + 1;
        for (auto bin = static_cast<std::uint32_t>(span.first[axis]); bin < end; ++bin) {
            const Box4 slab = with_range(box, axis, binning.plane(axis, bin), binning.plane(axis, bin + 1));
            const Box4 inside = intersect(box, slab);
            if (has_point(inside)) boxes_[axis][bin].merge(inside);
        }
    }
}

void SpatialBinSet::add(const SpatialBinSet& other) noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t bin = 0; bin < bin_count_; ++bin) {
            boxes_[axis][bin].merge(other.boxes_[axis][bin].box());
            entries_[axis][bin] += other.entries_[axis][bin];
            exits_[axis][bin] += other.exits_[axis][bin];
        }
    }
}

SpatialSplit SpatialBinSet::find_split(const SpatialBinning& binning, std::uint32_t most_references) const noexcept {
    SpatialSplit best;
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
        if (binning.divides(axis)) sweep_axis(axis, most_references, binning.unit(), best);
    }
    return best;
}

void SpatialBinSet::sweep_axis(std::uint32_t axis, std::uint32_t most_references, float unit,
                               SpatialSplit& best) const noexcept {
    const auto& boxes = boxes_[axis];
    std::array<BoxSlot, kMaxBinCount> right_boxes;
    std::array<std::uint32_t, kMaxBinCount> right_counts;
    Box4 box;
    std::uint32_t count = 0;
    for (std::uint32_t bin = bin_count_ - 1; bin > 0; --bin) {
        box.merge(boxes[bin].box());
        count += exits_[axis][bin];
        right_boxes[bin] = {box.lower, box.upper};
        right_counts[bin] = count;
    }
    box = Box4{};
    count = 0;
    for (std::uint32_t bin = 1; bin < bin_count_; ++bin) {
        box.merge(boxes[bin - 1].box());
        count += entries_[axis][bin - 1];
        const std::uint32_t right_count = right_counts[bin];
        if (count == 0 || right_count == 0 || count + right_count > most_references) continue;
        const float cost = box.half_area() * (static_cast<float>(count) * unit) +
                           right_boxes[bin].box().half_area() * (static_cast<float>(right_count) * unit);
        if (cost < best.cost) best = {cost, axis, bin, count, right_count, box, right_boxes[bin].box()};
    }
}

}  // namespace clbvh::host
