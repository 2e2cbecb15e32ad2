#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/ray.hpp"
#include "clbvh/export.h"

// CLBVH_NO_VECTORS tries on any processor what others without SSE2 run.
#if defined(__SSE2__) && !defined(CLBVH_NO_VECTORS)
#define CLBVH_TRACE_HAS_SSE2 1
#include <emmintrin.h>
#endif

// Infinities and NaNs take part in these tests. Where -ffast-math, or one of the flags that it stands for, lets the
// compiler forget about them, the functions are called in the library, which is compiled without; elsewhere they are
// inline. Each way has a namespace of its own, since both may be in one program. Distances, which may be infinite, are
// handed over by reference: clang with these flags lets no infinity pass as a value.
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__) || \
    defined(__ASSOCIATIVE_MATH__) || defined(__NO_SIGNED_ZEROS__) || defined(CLBVH_DEFINES_BOX_TESTS)
#define CLBVH_CALLS_BOX_TESTS 1
#define CLBVH_BOX_TESTS_NAMESPACE called_box_tests
#define CLBVH_BOX_TESTS_API CLBVH_API
#define CLBVH_BOX_TESTS_INLINE
#else
#define CLBVH_BOX_TESTS_NAMESPACE inline_box_tests
#define CLBVH_BOX_TESTS_API
// Always: a copy out of line in code that is compiled for AVX2 could become the one that all other code calls.
#if defined(__GNUC__)
#define CLBVH_BOX_TESTS_INLINE inline __attribute__((always_inline))
#else
#define CLBVH_BOX_TESTS_INLINE inline
#endif
#endif

namespace clbvh {

/// A box counts as met where the ray's entry is at most this factor beyond its exit. Ize 2013 proves that 1 + 2 units
/// in the last place makes the box test itself conservative; the rest is room for the rounding of a triangle's own t,
/// so that the box around a triangle never hides it.
inline constexpr float kBoxSlack = 1.0f + 0x1p-18f;

inline namespace CLBVH_BOX_TESTS_NAMESPACE {

/// False for a ray that hits nothing by definition: see Ray.
[[nodiscard]] CLBVH_BOX_TESTS_API bool is_traceable(const Ray& ray) noexcept;

/// Whether a ray that ends at t_max may still meet what it enters at t.
[[nodiscard]] CLBVH_BOX_TESTS_API bool reaches(const float& t_max, const float& t) noexcept;

/// A ray against one box. Directions of zero, also of negative zero, work: their slabs contain the ray always or never,
/// and where 0 * infinity makes a NaN, on a face of the box, the slab is left out.
class CLBVH_BOX_TESTS_API RaySlabs {
public:
    /// The ray is traceable.
    explicit RaySlabs(const Ray& ray) noexcept;

    /// Where the ray enters the box, or begins in it.
    [[nodiscard]] float entry(const Aabb& box) const noexcept;
    /// Where the ray leaves the box, or ends in it.
    [[nodiscard]] float exit(const Aabb& box, const float& t_max) const noexcept;
    /// Whether the ray up to t_max meets the box.
    [[nodiscard]] bool meets(const Aabb& box, const float& t_max) const noexcept;

    [[nodiscard]] float origin(unsigned axis) const noexcept { return origin_[axis]; }
    [[nodiscard]] float inverse(unsigned axis) const noexcept { return inverse_[axis]; }
    [[nodiscard]] float t_min() const noexcept { return t_min_; }
    /// Whether the ray enters boxes through their upper side of this axis.
    [[nodiscard]] bool enters_high(unsigned axis) const noexcept;

private:
    std::array<float, 3> origin_;
    std::array<float, 3> inverse_;
    float t_min_;
};

/// Where a ray enters each of two sibling boxes, and whether it meets them.
struct ChildEntries {
    std::array<float, 2> t;
    std::array<bool, 2> is_met;
};

/// Which child of two the ray enters first: the second only where it enters that one before the first.
[[nodiscard]] CLBVH_BOX_TESTS_API unsigned near_child(const ChildEntries& entries) noexcept;

/// A ray against the two boxes of a sibling pair at once: what RaySlabs has for each, to the bit.
class CLBVH_BOX_TESTS_API ChildBoxTest {
public:
    explicit ChildBoxTest(const RaySlabs& slabs) noexcept;

    void operator()(const Node* children, const float& t_max, ChildEntries& entries) const noexcept;

private:
#if defined(CLBVH_TRACE_HAS_SSE2)
    // Lanes: a value for both children that makes their entries, then one that makes their exits. Exits have their sign
    // turned, so that one maximum serves both.
    float t_min_;
    __m128 origins_[3];
    __m128 signed_inverses_[3];
    __m128 swaps_;  // all bits set on the axes along which the ray enters through the upper side
#else
    RaySlabs slabs_;
#endif
};

#if !defined(CLBVH_CALLS_BOX_TESTS) || defined(CLBVH_DEFINES_BOX_TESTS)

namespace box_tests {

using Corners = std::array<std::array<float, 3>, 2>;

inline Corners corners_of(const Aabb& box) noexcept {
    return {{{box.lower.x, box.lower.y, box.lower.z}, {box.upper.x, box.upper.y, box.upper.z}}};
}

}  // namespace box_tests

CLBVH_BOX_TESTS_INLINE bool is_traceable(const Ray& ray) noexcept {
    const Vec3& o = ray.origin;
    const Vec3& d = ray.direction;
    const bool is_finite = std::isfinite(o.x) && std::isfinite(o.y) && std::isfinite(o.z) && std::isfinite(d.x) &&
                           std::isfinite(d.y) && std::isfinite(d.z);
    return is_finite && (d.x != 0.0f || d.y != 0.0f || d.z != 0.0f) && ray.t_min <= ray.t_max;
}

CLBVH_BOX_TESTS_INLINE bool reaches(const float& t_max, const float& t) noexcept {
    return t <= t_max * kBoxSlack;
}

CLBVH_BOX_TESTS_INLINE RaySlabs::RaySlabs(const Ray& ray) noexcept
    : origin_{ray.origin.x, ray.origin.y, ray.origin.z},
      inverse_{1.0f / ray.direction.x, 1.0f / ray.direction.y, 1.0f / ray.direction.z},
      t_min_(ray.t_min > 0.0f ? ray.t_min : 0.0f) {}

CLBVH_BOX_TESTS_INLINE float RaySlabs::entry(const Aabb& box) const noexcept {
    const box_tests::Corners corners = box_tests::corners_of(box);
    float last = t_min_;
    for (unsigned axis = 0; axis < 3; ++axis) {
        const float t = (corners[enters_high(axis) ? 1 : 0][axis] - origin_[axis]) * inverse_[axis];
        last = t > last ? t : last;
    }
    return last;
}

CLBVH_BOX_TESTS_INLINE float RaySlabs::exit(const Aabb& box, const float& t_max) const noexcept {
    const box_tests::Corners corners = box_tests::corners_of(box);
    float first = t_max;
    for (unsigned axis = 0; axis < 3; ++axis) {
        const float t = (corners[enters_high(axis) ? 0 : 1][axis] - origin_[axis]) * inverse_[axis];
        first = t < first ? t : first;
    }
    return first;
}

CLBVH_BOX_TESTS_INLINE bool RaySlabs::meets(const Aabb& box, const float& t_max) const noexcept {
    return entry(box) <= exit(box, t_max) * kBoxSlack;
}

CLBVH_BOX_TESTS_INLINE bool RaySlabs::enters_high(unsigned axis) const noexcept {
    return std::signbit(inverse_[axis]);
}

CLBVH_BOX_TESTS_INLINE unsigned near_child(const ChildEntries& entries) noexcept {
    return entries.t[1] < entries.t[0] ? 1 : 0;
}

#if defined(CLBVH_TRACE_HAS_SSE2)

CLBVH_BOX_TESTS_INLINE ChildBoxTest::ChildBoxTest(const RaySlabs& slabs) noexcept : t_min_(slabs.t_min()) {
    for (unsigned axis = 0; axis < 3; ++axis) {
        const float inverse = slabs.inverse(axis);
        origins_[axis] = _mm_set1_ps(slabs.origin(axis));
        signed_inverses_[axis] = _mm_setr_ps(inverse, inverse, -inverse, -inverse);
    }
    const __m128 inverses = _mm_setr_ps(slabs.inverse(0), slabs.inverse(1), slabs.inverse(2), 0.0f);
    swaps_ = _mm_castsi128_ps(_mm_srai_epi32(_mm_castps_si128(inverses), 31));
}

CLBVH_BOX_TESTS_INLINE void ChildBoxTest::operator()(const Node* children, const float& t_max,
                                                     ChildEntries& entries) const noexcept {
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
    const int met = _mm_movemask_ps(_mm_cmple_ps(range, exits));
    const __m128 second = _mm_shuffle_ps(range, range, 1);
    entries = {{_mm_cvtss_f32(range), _mm_cvtss_f32(second)}, {(met & 1) != 0, (met & 2) != 0}};
}

#else

CLBVH_BOX_TESTS_INLINE ChildBoxTest::ChildBoxTest(const RaySlabs& slabs) noexcept : slabs_(slabs) {}

CLBVH_BOX_TESTS_INLINE void ChildBoxTest::operator()(const Node* children, const float& t_max,
                                                     ChildEntries& entries) const noexcept {
    const Aabb box0 = children[0].bounds(), box1 = children[1].bounds();
    entries = {{slabs_.entry(box0), slabs_.entry(box1)}, {slabs_.meets(box0, t_max), slabs_.meets(box1, t_max)}};
}

#endif

#endif

}  // namespace CLBVH_BOX_TESTS_NAMESPACE
}  // namespace clbvh
