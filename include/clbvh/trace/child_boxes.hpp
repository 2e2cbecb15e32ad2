#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/ray.hpp"

// CLBVH_NO_VECTORS tries on any processor what others without SSE2 run.
#if defined(__SSE2__) && !defined(CLBVH_NO_VECTORS)
#define CLBVH_TRACE_HAS_SSE2 1
#include <emmintrin.h>
#endif

namespace clbvh {

/// A box counts as met where the ray's entry is at most this factor beyond its exit. Ize 2013 proves that 1 + 2 units
/// in the last place makes the box test itself conservative; the rest is room for the rounding of a triangle's own t,
/// so that the box around a triangle never hides it.
inline constexpr float kBoxSlack = 1.0f + 0x1p-18f;

/// Where a ray enters each of two sibling boxes, and whether it meets them.
struct ChildEntries {
    std::array<float, 2> t;
    std::array<bool, 2> hit;
};

/// The ray's side of box tests. Directions of zero, also of negative zero, work: their slabs hold the ray for ever or
/// never, and where 0 * infinity makes a NaN, on a face of the box, the slab is left out.
class RayBoxTest {
public:
    /// The ray is traceable.
    explicit RayBoxTest(const Ray& ray) noexcept;

    /// Whether the ray up to t_max meets the box of `node`.
    [[nodiscard]] bool hits(const Node& node, float t_max) const noexcept {
        return entry(node) <= exit(node, t_max) * kBoxSlack;
    }

    /// Both boxes of the sibling pair at `children`: as hits() has it, to the bit.
    [[nodiscard]] ChildEntries enter(const Node* children, float t_max) const noexcept;

private:
    [[nodiscard]] float entry(const Node& node) const noexcept {
        float last = t_min_;
        for (unsigned axis = 0; axis < 3; ++axis) {
            const float near = std::signbit(inverse_[axis]) ? node.upper[axis] : node.lower[axis];
            const float t = (near - origin_[axis]) * inverse_[axis];
            last = t > last ? t : last;
        }
        return last;
    }
    [[nodiscard]] float exit(const Node& node, float t_max) const noexcept {
        float first = t_max;
        for (unsigned axis = 0; axis < 3; ++axis) {
            const float far = std::signbit(inverse_[axis]) ? node.lower[axis] : node.upper[axis];
            const float t = (far - origin_[axis]) * inverse_[axis];
            first = t < first ? t : first;
        }
        return first;
    }

    std::array<float, 3> origin_;
    std::array<float, 3> inverse_;
    float t_min_;
#if defined(CLBVH_TRACE_HAS_SSE2)
    // Lanes: a value of both children that makes their entries, then one that makes their exits. Exits are turned
    // around, so that one maximum serves both.
    __m128 origins_[3];
    __m128 signed_inverses_[3];
    __m128 swaps_;  // all bits set on the axes along which the ray enters through the upper side
#endif
};

#if defined(CLBVH_TRACE_HAS_SSE2)

inline RayBoxTest::RayBoxTest(const Ray& ray) noexcept
    : origin_{ray.origin.x, ray.origin.y, ray.origin.z},
      inverse_{1.0f / ray.direction.x, 1.0f / ray.direction.y, 1.0f / ray.direction.z},
      t_min_(ray.t_min > 0.0f ? ray.t_min : 0.0f) {
    for (unsigned axis = 0; axis < 3; ++axis) {
        origins_[axis] = _mm_set1_ps(origin_[axis]);
        signed_inverses_[axis] = _mm_setr_ps(inverse_[axis], inverse_[axis], -inverse_[axis], -inverse_[axis]);
    }
    const __m128i inverses = _mm_castps_si128(_mm_setr_ps(inverse_[0], inverse_[1], inverse_[2], 0.0f));
    swaps_ = _mm_castsi128_ps(_mm_srai_epi32(inverses, 31));
}

inline ChildEntries RayBoxTest::enter(const Node* children, float t_max) const noexcept {
    const __m128 lower0 = _mm_loadu_ps(children[0].lower), upper0 = _mm_loadu_ps(children[0].upper);
    const __m128 lower1 = _mm_loadu_ps(children[1].lower), upper1 = _mm_loadu_ps(children[1].upper);
    const __m128 change0 = _mm_and_ps(_mm_xor_ps(lower0, upper0), swaps_);
    const __m128 change1 = _mm_and_ps(_mm_xor_ps(lower1, upper1), swaps_);
    const __m128 near0 = _mm_xor_ps(lower0, change0), far0 = _mm_xor_ps(upper0, change0);
    const __m128 near1 = _mm_xor_ps(lower1, change1), far1 = _mm_xor_ps(upper1, change1);
    const __m128 near_xy = _mm_unpacklo_ps(near0, near1), far_xy = _mm_unpacklo_ps(far0, far1);
    const __m128 planes[3] = {_mm_movelh_ps(near_xy, far_xy), _mm_movehl_ps(far_xy, near_xy),
                              _mm_movelh_ps(_mm_unpackhi_ps(near0, near1), _mm_unpackhi_ps(far0, far1))};
    // A maximum is its second operand where the first is NaN.
    __m128 range = _mm_setr_ps(t_min_, t_min_, -t_max, -t_max);
    for (unsigned axis = 0; axis < 3; ++axis)
        range = _mm_max_ps(_mm_mul_ps(_mm_sub_ps(planes[axis], origins_[axis]), signed_inverses_[axis]), range);
    const __m128 exits = _mm_mul_ps(_mm_movehl_ps(range, range), _mm_set1_ps(-kBoxSlack));
    const int hits = _mm_movemask_ps(_mm_cmple_ps(range, exits));
    const __m128 second = _mm_shuffle_ps(range, range, 1);
    return {{_mm_cvtss_f32(range), _mm_cvtss_f32(second)}, {(hits & 1) != 0, (hits & 2) != 0}};
}

#else

inline RayBoxTest::RayBoxTest(const Ray& ray) noexcept
    : origin_{ray.origin.x, ray.origin.y, ray.origin.z},
      inverse_{1.0f / ray.direction.x, 1.0f / ray.direction.y, 1.0f / ray.direction.z},
      t_min_(ray.t_min > 0.0f ? ray.t_min : 0.0f) {}

inline ChildEntries RayBoxTest::enter(const Node* children, float t_max) const noexcept {
    return {{entry(children[0]), entry(children[1])}, {hits(children[0], t_max), hits(children[1], t_max)}};
}

#endif

}  // namespace clbvh
