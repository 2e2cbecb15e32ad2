#pragma once

// CLBVH_NO_VECTORS tries on any processor what others without SSE2 run.
#if defined(__SSE2__) && !defined(CLBVH_NO_VECTORS)
#define CLBVH_HAS_SSE2 1
#include <emmintrin.h>
#else
#include <array>
#include <bit>
#include <utility>
#endif

#include <cstddef>
#include <cstdint>

namespace clbvh {

/// Four floats that are worked on at once: three coordinates, and a fourth lane that does not matter.
/// SSE2 where the compiler has it (every x86-64), plain arrays elsewhere, with the same results.
struct Float4 {
#if defined(CLBVH_HAS_SSE2)
    __m128 lanes;

    [[nodiscard]] static Float4 load(const float* source) noexcept {
        return {_mm_loadu_ps(source)};
    }
    [[nodiscard]] static Float4 filled(float value) noexcept {
        return {_mm_set1_ps(value)};
    }
    [[nodiscard]] static Float4 of(float x, float y, float z) noexcept {
        return {_mm_setr_ps(x, y, z, 0.0f)};
    }
    void store(float* target) const noexcept {
        _mm_storeu_ps(target, lanes);
    }
    [[nodiscard]] float x() const noexcept {
        return _mm_cvtss_f32(lanes);
    }
    [[nodiscard]] float y() const noexcept {
        return _mm_cvtss_f32(_mm_shuffle_ps(lanes, lanes, 1));
    }
    [[nodiscard]] float z() const noexcept {
        return _mm_cvtss_f32(_mm_movehl_ps(lanes, lanes));
    }
    [[nodiscard]] Float4 negated() const noexcept {
        return {_mm_xor_ps(lanes, _mm_set1_ps(-0.0f))};
    }
    /// The same with 0 in the fourth lane, where bits of an integer may stand that would be slow to calculate with.
    [[nodiscard]] Float4 without_w() const noexcept {
        return {_mm_and_ps(lanes, _mm_castsi128_ps(_mm_setr_epi32(-1, -1, -1, 0)))};
    }

    /// The same with the bits of an integer in the fourth lane.
    [[nodiscard]] Float4 with_w(std::uint32_t bits) const noexcept {
        const __m128i w = _mm_slli_si128(_mm_cvtsi32_si128(static_cast<int>(bits)), 12);
        return {_mm_or_ps(without_w().lanes, _mm_castsi128_ps(w))};
    }

    friend Float4 operator+(Float4 a, Float4 b) noexcept {
        return {_mm_add_ps(a.lanes, b.lanes)};
    }
    friend Float4 operator-(Float4 a, Float4 b) noexcept {
        return {_mm_sub_ps(a.lanes, b.lanes)};
    }
    friend Float4 operator*(Float4 a, Float4 b) noexcept {
        return {_mm_mul_ps(a.lanes, b.lanes)};
    }
    friend Float4 min(Float4 a, Float4 b) noexcept {
        return {_mm_min_ps(a.lanes, b.lanes)};
    }
    friend Float4 max(Float4 a, Float4 b) noexcept {
        return {_mm_max_ps(a.lanes, b.lanes)};
    }
    /// Lane by lane, `a` where x < y, else `b`.
    friend Float4 select_less(Float4 x, Float4 y, Float4 a, Float4 b) noexcept {
        const __m128 less = _mm_cmplt_ps(x.lanes, y.lanes);
        return {_mm_or_ps(_mm_and_ps(less, a.lanes), _mm_andnot_ps(less, b.lanes))};
    }
    /// The first lanes of `a`, `b` and `c`, then the second ones, then the third ones.
    static void transpose(Float4& a, Float4& b, Float4& c) noexcept {
        const __m128 low = _mm_unpacklo_ps(a.lanes, b.lanes);
        const __m128 high = _mm_unpackhi_ps(a.lanes, b.lanes);
        const __m128 last = c.lanes;
        a.lanes = _mm_movelh_ps(low, last);
        b.lanes = _mm_shuffle_ps(low, last, _MM_SHUFFLE(1, 1, 3, 2));
        c.lanes = _mm_shuffle_ps(high, last, _MM_SHUFFLE(2, 2, 1, 0));
    }
    /// True where a <= b in each of the first three lanes.
    friend bool all_at_most(Float4 a, Float4 b) noexcept {
        return (_mm_movemask_ps(_mm_cmple_ps(a.lanes, b.lanes)) & 7) == 7;
    }
    /// Bit i is set where a <= b in lane i, all four of them.
    friend std::uint32_t lanes_at_most(Float4 a, Float4 b) noexcept {
        return static_cast<std::uint32_t>(_mm_movemask_ps(_mm_cmple_ps(a.lanes, b.lanes)));
    }
    /// Each lane rounded towards zero.
    void truncate(std::int32_t* target) const noexcept {
        _mm_storeu_si128(reinterpret_cast<__m128i*>(target), _mm_cvttps_epi32(lanes));
    }
#else
    std::array<float, 4> lanes;

    [[nodiscard]] static Float4 load(const float* source) noexcept {
        return {{source[0], source[1], source[2], source[3]}};
    }
    [[nodiscard]] static Float4 filled(float value) noexcept {
        return {{value, value, value, value}};
    }
    [[nodiscard]] static Float4 of(float x, float y, float z) noexcept {
        return {{x, y, z, 0.0f}};
    }
    void store(float* target) const noexcept {
        for (std::size_t i = 0; i < 4; ++i)
            target[i] = lanes[i];
    }
    [[nodiscard]] float x() const noexcept {
        return lanes[0];
    }
    [[nodiscard]] float y() const noexcept {
        return lanes[1];
    }
    [[nodiscard]] float z() const noexcept {
        return lanes[2];
    }
    [[nodiscard]] Float4 negated() const noexcept {
        return {{-lanes[0], -lanes[1], -lanes[2], -lanes[3]}};
    }
    [[nodiscard]] Float4 without_w() const noexcept {
        return {{lanes[0], lanes[1], lanes[2], 0.0f}};
    }
    [[nodiscard]] Float4 with_w(std::uint32_t bits) const noexcept {
        return {{lanes[0], lanes[1], lanes[2], std::bit_cast<float>(bits)}};
    }

    template <typename Operation>
    [[nodiscard]] static Float4 lane_by_lane(Float4 a, Float4 b, Operation operation) noexcept {
        Float4 result;
        for (std::size_t i = 0; i < 4; ++i)
            result.lanes[i] = operation(a.lanes[i], b.lanes[i]);
        return result;
    }
    friend Float4 operator+(Float4 a, Float4 b) noexcept {
        return lane_by_lane(a, b, [](float x, float y) { return x + y; });
    }
    friend Float4 operator-(Float4 a, Float4 b) noexcept {
        return lane_by_lane(a, b, [](float x, float y) { return x - y; });
    }
    friend Float4 operator*(Float4 a, Float4 b) noexcept {
        return lane_by_lane(a, b, [](float x, float y) { return x * y; });
    }
    friend Float4 min(Float4 a, Float4 b) noexcept {
        return lane_by_lane(a, b, [](float x, float y) { return x < y ? x : y; });
    }
    friend Float4 max(Float4 a, Float4 b) noexcept {
        return lane_by_lane(a, b, [](float x, float y) { return x > y ? x : y; });
    }
    friend Float4 select_less(Float4 x, Float4 y, Float4 a, Float4 b) noexcept {
        for (std::size_t i = 0; i < 4; ++i)
            b.lanes[i] = x.lanes[i] < y.lanes[i] ? a.lanes[i] : b.lanes[i];
        return b;
    }
    static void transpose(Float4& a, Float4& b, Float4& c) noexcept {
        std::swap(a.lanes[1], b.lanes[0]);
        std::swap(a.lanes[2], c.lanes[0]);
        std::swap(b.lanes[2], c.lanes[1]);
    }
    friend bool all_at_most(Float4 a, Float4 b) noexcept {
        return a.lanes[0] <= b.lanes[0] && a.lanes[1] <= b.lanes[1] && a.lanes[2] <= b.lanes[2];
    }
    friend std::uint32_t lanes_at_most(Float4 a, Float4 b) noexcept {
        std::uint32_t mask = 0;
        for (std::size_t i = 0; i < 4; ++i)
            mask |= (a.lanes[i] <= b.lanes[i] ? 1u : 0u) << i;
        return mask;
    }
    void truncate(std::int32_t* target) const noexcept {
        for (std::size_t i = 0; i < 4; ++i)
            target[i] = static_cast<std::int32_t>(lanes[i]);
    }
#endif
};

/// half_area() of a box whose extents are in the first three lanes, with the same order of operations.
[[nodiscard]] inline float half_area_of_extents(Float4 extents) noexcept {
    const float x = extents.x();
    const float y = extents.y();
    const float z = extents.z();
    return x * (y + z) + y * z;
}

/// The same for three boxes at once, in the first three lanes.
[[nodiscard]] inline Float4 half_areas_of_extents(Float4 a, Float4 b, Float4 c) noexcept {
    Float4::transpose(a, b, c);
    return a * (b + c) + b * c;
}

/// Four integers that are counted with.
struct Int4 {
#if defined(CLBVH_HAS_SSE2)
    __m128i lanes = _mm_setzero_si128();

    [[nodiscard]] static Int4 load(const std::int32_t* source) noexcept {
        return {_mm_loadu_si128(reinterpret_cast<const __m128i*>(source))};
    }
    friend Int4 operator+(Int4 a, Int4 b) noexcept {
        return {_mm_add_epi32(a.lanes, b.lanes)};
    }
    [[nodiscard]] Float4 to_float() const noexcept {
        return {_mm_cvtepi32_ps(lanes)};
    }
#else
    std::array<std::int32_t, 4> lanes{};

    [[nodiscard]] static Int4 load(const std::int32_t* source) noexcept {
        return {{source[0], source[1], source[2], source[3]}};
    }
    friend Int4 operator+(Int4 a, Int4 b) noexcept {
        for (std::size_t i = 0; i < 4; ++i)
            a.lanes[i] += b.lanes[i];
        return a;
    }
    [[nodiscard]] Float4 to_float() const noexcept {
        Float4 result;
        for (std::size_t i = 0; i < 4; ++i)
            result.lanes[i] = static_cast<float>(lanes[i]);
        return result;
    }
#endif
};

}  // namespace clbvh
