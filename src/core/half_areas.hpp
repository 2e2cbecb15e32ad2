#pragma once

#include <array>

#include "core/simd/box4.hpp"

namespace clbvh {

/// The half areas of four boxes at once, each as Box4::half_area() gives it, to the bit.
[[nodiscard]] inline std::array<float, 4> half_areas(const std::array<Box4, 4>& boxes) noexcept {
#if defined(CLBVH_HAS_SSE2)
    __m128 a = (boxes[0].upper - boxes[0].lower).lanes;
    __m128 b = (boxes[1].upper - boxes[1].lower).lanes;
    __m128 c = (boxes[2].upper - boxes[2].lower).lanes;
    __m128 d = (boxes[3].upper - boxes[3].lower).lanes;
    _MM_TRANSPOSE4_PS(a, b, c, d);
    std::array<float, 4> areas;
    _mm_storeu_ps(areas.data(), _mm_add_ps(_mm_mul_ps(a, _mm_add_ps(b, c)), _mm_mul_ps(b, c)));
    return areas;
#else
    return {boxes[0].half_area(), boxes[1].half_area(), boxes[2].half_area(), boxes[3].half_area()};
#endif
}

}  // namespace clbvh
