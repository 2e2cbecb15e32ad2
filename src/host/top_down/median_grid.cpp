#include "host/top_down/median_grid.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace clbvh::host {
namespace {

std::array<float, 3> array_of(const Vec3& v) noexcept {
    return {v.x, v.y, v.z};
}

/// As many levels as leave each cell four times as wide as the spacing of floats there.
std::uint32_t count_levels(float begin, float end) noexcept {
    const double largest = std::max(std::abs(double{begin}), std::abs(double{end}));
    const double step = std::max(largest * 0x1p-23, double{std::numeric_limits<float>::denorm_min()});
    const double steps = (double{end} - double{begin}) / step;
    if (!(steps >= 8.0)) return 0;
    return std::min(MedianGrid::kMostLevels, static_cast<std::uint32_t>(std::ilogb(steps)) - 2);
}

}  // namespace

MedianGrid::Axis::Axis(float begin, float end) noexcept
    : lower(begin),
      cell(std::ldexp(double{end} - double{begin}, -static_cast<int>(count_levels(begin, end)))),
      levels(count_levels(begin, end)) {}

MedianGrid::MedianGrid(const Aabb& scene) noexcept
    : axes_{Axis{scene.lower.x, scene.upper.x}, Axis{scene.lower.y, scene.upper.y},
            Axis{scene.lower.z, scene.upper.z}} {}

// Both begin with what the division says, and go on to what the rounded planes say, a step further at most.

std::int64_t MedianGrid::Axis::last_plane_up_to(float place) const noexcept {
    auto index = static_cast<std::int64_t>((double{place} - lower) / cell);
    if (plane(index) > place) return index - 1;
    return plane(index + 1) <= place ? index + 1 : index;
}

std::int64_t MedianGrid::Axis::last_plane_below(float place) const noexcept {
    auto index = static_cast<std::int64_t>((double{place} - lower) / cell);
    if (plane(index) >= place) return index - 1;
    return plane(index + 1) < place ? index + 1 : index;
}

std::optional<MedianGrid::Plane> MedianGrid::most_important(const Aabb& box) const noexcept {
    const std::array<float, 3> lower = array_of(box.lower);
    const std::array<float, 3> upper = array_of(box.upper);
    std::optional<Plane> best;
    float longest = 0.0f;
    for (std::size_t i = 0; i < 3; ++i) {
        if (axes_[i].levels == 0 || !(lower[i] < upper[i])) continue;
        const std::int64_t first = axes_[i].last_plane_up_to(lower[i]);
        const std::int64_t last = axes_[i].last_plane_below(upper[i]);
        if (last <= first) continue;
        // Of the planes first + 1 .. last, the one whose number has most zeros at its end.
        const auto bit = static_cast<std::uint32_t>(std::bit_width(static_cast<std::uint64_t>(first ^ last))) - 1;
        const Plane plane{i, axes_[i].levels - 1 - bit, axes_[i].plane(last >> bit << bit)};
        const float length = upper[i] - lower[i];
        if (best && (plane.level > best->level || (plane.level == best->level && length <= longest))) continue;
        best = plane;
        longest = length;
    }
    return best;
}

}  // namespace clbvh::host
