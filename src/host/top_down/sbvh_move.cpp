#include "host/top_down/sbvh_move.hpp"

namespace clbvh::host {
namespace {

float merged_area(Box4 a, const Box4& b) noexcept {
    a.merge(b);
    return a.half_area();
}

}  // namespace

SpatialRule::SpatialRule(const MeshView* mesh, const SpatialBinning& binning, const SpatialSplit& split) noexcept
    : mesh_(mesh),
      binning_(binning),
      split_(split),
      plane_(binning.plane(split.axis, split.bin)),
      left_area_(split.left_box.half_area()),
      right_area_(split.right_box.half_area()) {}

SpatialRule::Parts SpatialRule::cut(const Reference& reference) const noexcept {
    const CutReference parts = cut_reference(mesh_, reference, split_.axis, plane_);
    const Reference left = make_reference(parts.left, reference.primitive);
    const Reference right = make_reference(parts.right, reference.primitive);
    const bool has_left = has_point(parts.left);
    const bool has_right = has_point(parts.right);
    if (!has_left && !has_right) return {true, false, reference, {}};
    if (!has_left || !has_right) return {has_left, has_right, left, right};

    // Section 4.4, reference unsplitting. "The bounding boxes of both children" are here those of the split that was
    // found, not as they have grown since, so that no reference's way depends on another's.
    const Box4 box = Box4::of(reference);
    const float unit = binning_.unit();
    const float left_count = static_cast<float>(split_.left_count) * unit;
    const float right_count = static_cast<float>(split_.right_count) * unit;
    const float cut_cost = left_area_ * left_count + right_area_ * right_count;
    const float left_cost = merged_area(split_.left_box, box) * left_count + right_area_ * (right_count - unit);
    const float right_cost = left_area_ * (left_count - unit) + merged_area(split_.right_box, box) * right_count;
    if (std::min(left_cost, right_cost) >= cut_cost) return {true, true, left, right};
    const bool goes_right = right_cost < left_cost;
    return {!goes_right, goes_right, reference, reference};
}

std::array<SpacedRange, 2> Division::ranges(const SpacedRange& whole) const noexcept {
    const std::uint32_t spare = whole.capacity() - counts[0] - counts[1];
    const double area = halves[0].area + halves[1].area;
    double left_share = area > 0.0 ? halves[0].area / area : 0.5;
    if (counts[1] == 1) left_share = 1.0;
    if (counts[0] == 1) left_share = 0.0;
    const std::uint32_t border = whole.begin + counts[0] + static_cast<std::uint32_t>(left_share * spare);
    return {{{whole.begin, border, whole.begin, counts[0]}, {border, whole.end, whole.end - counts[1], counts[1]}}};
}

}  // namespace clbvh::host
