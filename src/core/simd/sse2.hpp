#pragma once

#include <emmintrin.h>

#include <bit>
#include <cstddef>
#include <cstdint>

#include "core/simd/always_inline.hpp"
#include "core/simd/pair.hpp"

/// The vectors of SSE2, which every x86-64 has. scalar.hpp says what each function does.
namespace clbvh::simd::sse2 {

struct Mask4 {
    __m128 lanes;

    [[nodiscard]] CLBVH_ALWAYS_INLINE std::uint32_t bits() const noexcept {
        return static_cast<std::uint32_t>(_mm_movemask_ps(lanes));
    }
    friend CLBVH_ALWAYS_INLINE Mask4 operator|(Mask4 a, Mask4 b) noexcept { return {_mm_or_ps(a.lanes, b.lanes)}; }
};

struct Float4 {
    static constexpr std::uint32_t kCount = 4;
    using Mask = Mask4;

    __m128 lanes;

    [[nodiscard]] static CLBVH_ALWAYS_INLINE Float4 load(const float* source) noexcept {
        return {_mm_loadu_ps(source)};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Float4 load_aligned(const float* source) noexcept {
        return {_mm_load_ps(source)};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Float4 filled(float value) noexcept { return {_mm_set1_ps(value)}; }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Float4 filled_with_bits(std::uint32_t bits) noexcept {
        return {_mm_castsi128_ps(_mm_set1_epi32(static_cast<int>(bits)))};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Float4 of(float x, float y, float z) noexcept {
        return {_mm_setr_ps(x, y, z, 0.0f)};
    }
    CLBVH_ALWAYS_INLINE void store(float* target) const noexcept { _mm_storeu_ps(target, lanes); }
    CLBVH_ALWAYS_INLINE void store_aligned(float* target) const noexcept { _mm_store_ps(target, lanes); }
    CLBVH_ALWAYS_INLINE void store_first(std::uint32_t count, float* target) const noexcept {
        select(first_lanes(count), *this, load(target)).store(target);
    }

    [[nodiscard]] CLBVH_ALWAYS_INLINE float x() const noexcept { return _mm_cvtss_f32(lanes); }
    [[nodiscard]] CLBVH_ALWAYS_INLINE float y() const noexcept {
        return _mm_cvtss_f32(_mm_shuffle_ps(lanes, lanes, 1));
    }
    [[nodiscard]] CLBVH_ALWAYS_INLINE float z() const noexcept { return _mm_cvtss_f32(_mm_movehl_ps(lanes, lanes)); }
    [[nodiscard]] CLBVH_ALWAYS_INLINE float least() const noexcept {
        const __m128 twos = _mm_min_ps(lanes, _mm_movehl_ps(lanes, lanes));
        return _mm_cvtss_f32(_mm_min_ss(twos, _mm_shuffle_ps(twos, twos, 1)));
    }
    [[nodiscard]] CLBVH_ALWAYS_INLINE Float4 negated() const noexcept {
        return {_mm_xor_ps(lanes, _mm_set1_ps(-0.0f))};
    }
    [[nodiscard]] CLBVH_ALWAYS_INLINE Float4 without_w() const noexcept {
        return {_mm_and_ps(lanes, _mm_castsi128_ps(_mm_setr_epi32(-1, -1, -1, 0)))};
    }
    [[nodiscard]] CLBVH_ALWAYS_INLINE Float4 with_w(std::uint32_t bits) const noexcept {
        const __m128i w = _mm_slli_si128(_mm_cvtsi32_si128(static_cast<int>(bits)), 12);
        return {_mm_or_ps(without_w().lanes, _mm_castsi128_ps(w))};
    }
    CLBVH_ALWAYS_INLINE void truncate(std::int32_t* target) const noexcept {
        _mm_storeu_si128(reinterpret_cast<__m128i*>(target), _mm_cvttps_epi32(lanes));
    }

    friend CLBVH_ALWAYS_INLINE Float4 operator+(Float4 a, Float4 b) noexcept { return {_mm_add_ps(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Float4 operator-(Float4 a, Float4 b) noexcept { return {_mm_sub_ps(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Float4 operator*(Float4 a, Float4 b) noexcept { return {_mm_mul_ps(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Float4 operator/(Float4 a, Float4 b) noexcept { return {_mm_div_ps(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Float4 min(Float4 a, Float4 b) noexcept { return {_mm_min_ps(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Float4 max(Float4 a, Float4 b) noexcept { return {_mm_max_ps(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Mask less(Float4 a, Float4 b) noexcept { return {_mm_cmplt_ps(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Mask less_equal(Float4 a, Float4 b) noexcept { return {_mm_cmple_ps(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Mask equal(Float4 a, Float4 b) noexcept { return {_mm_cmpeq_ps(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Mask same_bits(Float4 a, Float4 b) noexcept {
        return {_mm_castsi128_ps(_mm_cmpeq_epi32(_mm_castps_si128(a.lanes), _mm_castps_si128(b.lanes)))};
    }
    friend CLBVH_ALWAYS_INLINE Float4 select(Mask mask, Float4 a, Float4 b) noexcept {
        return {_mm_or_ps(_mm_and_ps(mask.lanes, a.lanes), _mm_andnot_ps(mask.lanes, b.lanes))};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Mask first_lanes(std::uint32_t count) noexcept {
        alignas(16) static constexpr std::int32_t inside[8] = {-1, -1, -1, -1, 0, 0, 0, 0};
        const std::uint32_t skipped = count < kCount ? kCount - count : 0;
        return {_mm_castsi128_ps(_mm_loadu_si128(reinterpret_cast<const __m128i*>(inside + skipped)))};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Mask only_lane(std::uint32_t lane) noexcept {
        return {_mm_castsi128_ps(_mm_cmpeq_epi32(_mm_setr_epi32(0, 1, 2, 3), _mm_set1_epi32(static_cast<int>(lane))))};
    }
    static CLBVH_ALWAYS_INLINE void transpose(Float4& a, Float4& b, Float4& c) noexcept {
        const __m128 low = _mm_unpacklo_ps(a.lanes, b.lanes);
        const __m128 high = _mm_unpackhi_ps(a.lanes, b.lanes);
        const __m128 last = c.lanes;
        a.lanes = _mm_movelh_ps(low, last);
        b.lanes = _mm_shuffle_ps(low, last, _MM_SHUFFLE(1, 1, 3, 2));
        c.lanes = _mm_shuffle_ps(high, last, _MM_SHUFFLE(2, 2, 1, 0));
    }
    static CLBVH_ALWAYS_INLINE void transpose(Float4& a, Float4& b, Float4& c, Float4& d) noexcept {
        _MM_TRANSPOSE4_PS(a.lanes, b.lanes, c.lanes, d.lanes);
    }
};

struct Int4 {
    __m128i lanes = _mm_setzero_si128();

    [[nodiscard]] static CLBVH_ALWAYS_INLINE Int4 load(const std::int32_t* source) noexcept {
        return {_mm_loadu_si128(reinterpret_cast<const __m128i*>(source))};
    }
    friend CLBVH_ALWAYS_INLINE Int4 operator+(Int4 a, Int4 b) noexcept { return {_mm_add_epi32(a.lanes, b.lanes)}; }
    [[nodiscard]] CLBVH_ALWAYS_INLINE Float4 to_float() const noexcept { return {_mm_cvtepi32_ps(lanes)}; }
};

struct Double2 {
    __m128d lanes;

    [[nodiscard]] static CLBVH_ALWAYS_INLINE Double2 of_x(Float4 a, Float4 b) noexcept {
        return {_mm_cvtps_pd(_mm_unpacklo_ps(a.lanes, b.lanes))};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Double2 of_y(Float4 a, Float4 b) noexcept {
        const __m128 low = _mm_unpacklo_ps(a.lanes, b.lanes);
        return {_mm_cvtps_pd(_mm_movehl_ps(low, low))};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Double2 of_z(Float4 a, Float4 b) noexcept {
        return {_mm_cvtps_pd(_mm_unpackhi_ps(a.lanes, b.lanes))};
    }
    CLBVH_ALWAYS_INLINE void store(double* target) const noexcept { _mm_storeu_pd(target, lanes); }
    friend CLBVH_ALWAYS_INLINE Double2 operator+(Double2 a, Double2 b) noexcept {
        return {_mm_add_pd(a.lanes, b.lanes)};
    }
    friend CLBVH_ALWAYS_INLINE Double2 operator-(Double2 a, Double2 b) noexcept {
        return {_mm_sub_pd(a.lanes, b.lanes)};
    }
    friend CLBVH_ALWAYS_INLINE Double2 operator*(Double2 a, Double2 b) noexcept {
        return {_mm_mul_pd(a.lanes, b.lanes)};
    }
};

struct Set {
    using Float4 = sse2::Float4;
    using Int4 = sse2::Int4;
    using Float8 = Pair<Float4>;
    using Widest = Float4;
};

}  // namespace clbvh::simd::sse2
