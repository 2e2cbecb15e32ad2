#pragma once

#include "clbvh/core/aabb.hpp"

namespace clbvh {

/// The box that both share; where they are apart, lower is above upper along some axis.
[[nodiscard]] constexpr Aabb intersect(const Aabb& a, const Aabb& b) noexcept {
    return {max(a.lower, b.lower), min(a.upper, b.upper)};
}

/// True where the boxes have a point in common.
[[nodiscard]] constexpr bool touch(const Aabb& a, const Aabb& b) noexcept {
    return a.lower.x <= b.upper.x && b.lower.x <= a.upper.x && a.lower.y <= b.upper.y && b.lower.y <= a.upper.y &&
           a.lower.z <= b.upper.z && b.lower.z <= a.upper.z;
}

/// True where `inner` has no point that `outer` has not.
[[nodiscard]] constexpr bool is_within(const Aabb& inner, const Aabb& outer) noexcept {
    return merge(inner, outer) == outer;
}

}  // namespace clbvh
