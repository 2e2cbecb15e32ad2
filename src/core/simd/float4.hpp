#pragma once

#include <cstdint>

// CLBVH_NO_VECTORS tries on any processor what those without SSE2 and NEON run.
#if defined(__SSE2__) && !defined(CLBVH_NO_VECTORS)
#define CLBVH_HAS_SSE2 1
#include "core/simd/sse2.hpp"
#elif defined(__aarch64__) && !defined(CLBVH_NO_VECTORS)
#define CLBVH_HAS_NEON 1
#include "core/simd/neon.hpp"
#else
#include "core/simd/scalar.hpp"
#endif

namespace clbvh {

// The vectors that every processor has for which the library is compiled.
namespace simd {
#if defined(CLBVH_HAS_SSE2)
namespace baseline = sse2;
#elif defined(CLBVH_HAS_NEON)
namespace baseline = neon;
#else
namespace baseline = scalar;
#endif
}  // namespace simd

/// Four floats that are worked on at once: three coordinates, and a fourth lane that does not matter.
using Float4 = simd::baseline::Float4;
/// Four integers that are counted with.
using Int4 = simd::baseline::Int4;
/// The same lane of two vectors, in double precision.
using Double2 = simd::baseline::Double2;

/// True where a <= b in each of the first three lanes.
[[nodiscard]] CLBVH_ALWAYS_INLINE bool all_at_most(Float4 a, Float4 b) noexcept {
    return (less_equal(a, b).bits() & 7) == 7;
}

/// half_area() of a box whose extents are in the first three lanes, with the same order of operations.
template <typename Vector>
[[nodiscard]] CLBVH_ALWAYS_INLINE float half_area_of_extents(Vector extents) noexcept {
    const float x = extents.x();
    const float y = extents.y();
    const float z = extents.z();
    return x * (y + z) + y * z;
}

/// The same for three boxes at once, in the first three lanes.
template <typename Vector>
[[nodiscard]] CLBVH_ALWAYS_INLINE Vector half_areas_of_extents(Vector a, Vector b, Vector c) noexcept {
    Vector::transpose(a, b, c);
    return a * (b + c) + b * c;
}

}  // namespace clbvh
