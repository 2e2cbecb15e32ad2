#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "clbvh/core/primitives.hpp"

namespace clbvh::host {

/// A corner of a triangle that is being split. In double precision, so that midpoints are nearly always exact.
struct Corner {
    double x;
    double y;
    double z;
    std::uint32_t vertex;  ///< Whatever the sink of subdivide() calls it.
};
using Corners = std::array<Corner, 3>;

[[nodiscard]] inline Corners corners_of(const MeshView& mesh, const Triangle& triangle) noexcept {
    Corners corners;
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 v = mesh.vertex(triangle[i]);
        corners[i] = {v.x, v.y, v.z, triangle[i]};
    }
    return corners;
}

/// Volume of the box around an edge; the same from both ends.
[[nodiscard]] inline double edge_volume(const Corner& a, const Corner& b) noexcept {
    return std::abs(a.x - b.x) * std::abs(a.y - b.y) * std::abs(a.z - b.z);
}

/// The same point from both ends. It is off the exact one by no more than one rounding in double precision.
[[nodiscard]] inline Corner midpoint(const Corner& a, const Corner& b) noexcept {
    return {0.5 * (a.x + b.x), 0.5 * (a.y + b.y), 0.5 * (a.z + b.z), 0};
}

/// Most splits between a triangle and one of its parts. The area halves each time, so that only a threshold far below
/// what a budget allows could ask for more.
inline constexpr std::uint32_t kMaxSplitDepth = 96;

/// Splits a triangle at the middle of the edge of largest volume, and its halves likewise, until no edge is above
/// `threshold`. An edge above it is thus split in every triangle that has it, whichever edges come first there.
/// Tells `sink` of each new corner (`add_vertex(corner)` returns what to call it) and of each part, left to right
/// (`add_part(corners)` returns false to stop). Returns false where it was stopped, or reached kMaxSplitDepth.
template <typename Sink>
bool subdivide(const Corners& corners, double threshold, Sink& sink, std::uint32_t depth = 0) {
    std::size_t edge = 0;
    double largest = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        const double volume = edge_volume(corners[i], corners[(i + 1) % 3]);
        if (volume > largest) {
            largest = volume;
            edge = i;
        }
    }
    if (largest <= threshold) return sink.add_part(corners);
    if (depth == kMaxSplitDepth) return false;
    const Corner& a = corners[edge];
    const Corner& b = corners[(edge + 1) % 3];
    const Corner& c = corners[(edge + 2) % 3];
    Corner middle = midpoint(a, b);
    middle.vertex = sink.add_vertex(middle);
    return subdivide({a, middle, c}, threshold, sink, depth + 1) &&
           subdivide({middle, b, c}, threshold, sink, depth + 1);
}

}  // namespace clbvh::host
