#pragma once

#include <array>

#include "clbvh/core/bvh.hpp"
#include "core/simd/box4.hpp"

namespace clbvh {

/// Half the surface area in double precision, so that no rounding makes a change look good: x * y + y * z + z * x over
/// the extents.
[[nodiscard]] constexpr double exact_half_area(const Aabb& box) noexcept {
    const double x = double{box.upper.x} - double{box.lower.x};
    const double y = double{box.upper.y} - double{box.lower.y};
    const double z = double{box.upper.z} - double{box.lower.z};
    return x * y + y * z + z * x;
}
[[nodiscard]] constexpr double exact_half_area(const Node& node) noexcept {
    return exact_half_area(node.bounds());
}

/// Those of two boxes at once, to the bit. What stands in the fourth lanes does not matter.
[[nodiscard]] inline std::array<double, 2> exact_half_areas(const Box4& a, const Box4& b) noexcept {
#if defined(CLBVH_HAS_SSE2)
    // x and y of both boxes, then z of both.
    const __m128 lower = _mm_unpacklo_ps(a.lower.lanes, b.lower.lanes);
    const __m128 upper = _mm_unpacklo_ps(a.upper.lanes, b.upper.lanes);
    const __m128 lower_z = _mm_unpackhi_ps(a.lower.lanes, b.lower.lanes);
    const __m128 upper_z = _mm_unpackhi_ps(a.upper.lanes, b.upper.lanes);
    const auto extents = [](__m128 from, __m128 to) { return _mm_sub_pd(_mm_cvtps_pd(to), _mm_cvtps_pd(from)); };
    const __m128d x = extents(lower, upper);
    const __m128d y = extents(_mm_movehl_ps(lower, lower), _mm_movehl_ps(upper, upper));
    const __m128d z = extents(lower_z, upper_z);
    std::array<double, 2> areas;
    _mm_storeu_pd(areas.data(), _mm_add_pd(_mm_add_pd(_mm_mul_pd(x, y), _mm_mul_pd(y, z)), _mm_mul_pd(z, x)));
    return areas;
#else
    return {exact_half_area(make_node(a, 0, 0)), exact_half_area(make_node(b, 0, 0))};
#endif
}

}  // namespace clbvh
