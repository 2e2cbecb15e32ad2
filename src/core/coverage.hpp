#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"

namespace clbvh {

/// How far beyond a box a point still counts as covered by it, relative to the largest coordinate of the triangle: more
/// than the proof's own rounding in double precision, and a thousandth of what a float can tell apart.
inline constexpr double kCoverageTolerance = 0x1p-34;

/// Proves that `boxes` together cover the triangle, also one without an area. Returns nothing, or a point of the
/// triangle in none of them. Time about k log k for k boxes that overlap little.
[[nodiscard]] std::optional<Vec3> find_uncovered_point(const std::array<Vec3, 3>& triangle,
                                                       std::span<const Aabb> boxes);

/// The same for a box, also a flat one, without a tolerance: nothing is rounded.
[[nodiscard]] std::optional<Vec3> find_uncovered_point(const Aabb& whole, std::span<const Aabb> boxes);

/// A place where a primitive is in none of the leaves that name it.
struct LostPart {
    std::size_t primitive;
    Vec3 point;
};

/// Proves, in parallel, that every active primitive is covered by the leaves of `bvh`, which are nodes `leaves`, that
/// name it. Returns nothing, or the first primitive of which a part is lost. Every reference must be in range.
[[nodiscard]] std::optional<LostPart> find_lost_part(const Bvh& bvh, const Primitives& primitives,
                                                     std::span<const std::uint32_t> leaves);

}  // namespace clbvh
