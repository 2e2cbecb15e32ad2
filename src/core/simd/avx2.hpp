#pragma once

#include <immintrin.h>

#include <cstdint>

#include "core/simd/sse2.hpp"

/// The vectors of AVX2, for files that are compiled for it alone. scalar.hpp says what each function does.
namespace clbvh::simd::avx2 {

struct Int8;

struct Mask8 {
    __m256 lanes;

    [[nodiscard]] CLBVH_ALWAYS_INLINE std::uint32_t bits() const noexcept {
        return static_cast<std::uint32_t>(_mm256_movemask_ps(lanes));
    }
    friend CLBVH_ALWAYS_INLINE Mask8 operator|(Mask8 a, Mask8 b) noexcept { return {_mm256_or_ps(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Mask8 operator&(Mask8 a, Mask8 b) noexcept { return {_mm256_and_ps(a.lanes, b.lanes)}; }
    /// Lanes of `a` that are not in `b`.
    friend CLBVH_ALWAYS_INLINE Mask8 except(Mask8 a, Mask8 b) noexcept { return {_mm256_andnot_ps(b.lanes, a.lanes)}; }
};

struct Float8 {
    static constexpr std::uint32_t kCount = 8;
    using Mask = Mask8;

    __m256 lanes;

    [[nodiscard]] static CLBVH_ALWAYS_INLINE Float8 load(const float* source) noexcept {
        return {_mm256_loadu_ps(source)};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Float8 load_aligned(const float* source) noexcept {
        return {_mm256_load_ps(source)};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Float8 filled(float value) noexcept { return {_mm256_set1_ps(value)}; }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Float8 filled_with_bits(std::uint32_t bits) noexcept {
        return {_mm256_castsi256_ps(_mm256_set1_epi32(static_cast<int>(bits)))};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Float8 of_halves(sse2::Float4 low, sse2::Float4 high) noexcept {
        return {_mm256_insertf128_ps(_mm256_castps128_ps256(low.lanes), high.lanes, 1)};
    }
    CLBVH_ALWAYS_INLINE void store(float* target) const noexcept { _mm256_storeu_ps(target, lanes); }
    CLBVH_ALWAYS_INLINE void store_aligned(float* target) const noexcept { _mm256_store_ps(target, lanes); }
    CLBVH_ALWAYS_INLINE void store_first(std::uint32_t count, float* target) const noexcept {
        _mm256_maskstore_ps(target, _mm256_castps_si256(first_lanes(count).lanes), lanes);
    }

    [[nodiscard]] CLBVH_ALWAYS_INLINE float x() const noexcept { return low_half().x(); }
    [[nodiscard]] CLBVH_ALWAYS_INLINE sse2::Float4 low_half() const noexcept { return {_mm256_castps256_ps128(lanes)}; }
    [[nodiscard]] CLBVH_ALWAYS_INLINE sse2::Float4 high_half() const noexcept {
        return {_mm256_extractf128_ps(lanes, 1)};
    }
    [[nodiscard]] CLBVH_ALWAYS_INLINE float least() const noexcept { return min(low_half(), high_half()).least(); }
    /// The same in every lane.
    [[nodiscard]] CLBVH_ALWAYS_INLINE Float8 least_everywhere() const noexcept {
        const __m256 fours = _mm256_min_ps(lanes, _mm256_permute2f128_ps(lanes, lanes, 1));
        const __m256 twos = _mm256_min_ps(fours, _mm256_permute_ps(fours, 0x4e));
        return {_mm256_min_ps(twos, _mm256_permute_ps(twos, 0xb1))};
    }
    /// In each half, lane kLane of that half everywhere.
    template <int kLane>
    [[nodiscard]] CLBVH_ALWAYS_INLINE Float8 spread() const noexcept {
        return {_mm256_permute_ps(lanes, kLane * 0b01010101)};
    }
    [[nodiscard]] CLBVH_ALWAYS_INLINE Float8 with_negated_high_half() const noexcept {
        return {_mm256_xor_ps(lanes, _mm256_setr_ps(0.0f, 0.0f, 0.0f, 0.0f, -0.0f, -0.0f, -0.0f, -0.0f))};
    }

    friend CLBVH_ALWAYS_INLINE Float8 operator+(Float8 a, Float8 b) noexcept {
        return {_mm256_add_ps(a.lanes, b.lanes)};
    }
    friend CLBVH_ALWAYS_INLINE Float8 operator-(Float8 a, Float8 b) noexcept {
        return {_mm256_sub_ps(a.lanes, b.lanes)};
    }
    friend CLBVH_ALWAYS_INLINE Float8 operator*(Float8 a, Float8 b) noexcept {
        return {_mm256_mul_ps(a.lanes, b.lanes)};
    }
    friend CLBVH_ALWAYS_INLINE Float8 operator/(Float8 a, Float8 b) noexcept {
        return {_mm256_div_ps(a.lanes, b.lanes)};
    }
    friend CLBVH_ALWAYS_INLINE Float8 min(Float8 a, Float8 b) noexcept { return {_mm256_min_ps(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Float8 max(Float8 a, Float8 b) noexcept { return {_mm256_max_ps(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Mask less(Float8 a, Float8 b) noexcept {
        return {_mm256_cmp_ps(a.lanes, b.lanes, _CMP_LT_OQ)};
    }
    friend CLBVH_ALWAYS_INLINE Mask less_equal(Float8 a, Float8 b) noexcept {
        return {_mm256_cmp_ps(a.lanes, b.lanes, _CMP_LE_OQ)};
    }
    friend CLBVH_ALWAYS_INLINE Mask equal(Float8 a, Float8 b) noexcept {
        return {_mm256_cmp_ps(a.lanes, b.lanes, _CMP_EQ_OQ)};
    }
    friend CLBVH_ALWAYS_INLINE Mask same_bits(Float8 a, Float8 b) noexcept {
        return {_mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_castps_si256(a.lanes), _mm256_castps_si256(b.lanes)))};
    }
    friend CLBVH_ALWAYS_INLINE Float8 select(Mask mask, Float8 a, Float8 b) noexcept {
        return {_mm256_blendv_ps(b.lanes, a.lanes, mask.lanes)};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Mask first_lanes(std::uint32_t count) noexcept {
        alignas(32) static constexpr std::int32_t inside[16] = {-1, -1, -1, -1, -1, -1, -1, -1, 0, 0, 0, 0, 0, 0, 0, 0};
        const std::uint32_t taken = count < kCount ? count : kCount;
        return {_mm256_castsi256_ps(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(inside + kCount - taken)))};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Mask only_lane(std::uint32_t lane) noexcept;
};

/// Eight integers: numbers of lanes.
struct Int8 {
    __m256i lanes;

    [[nodiscard]] static CLBVH_ALWAYS_INLINE Int8 load(const std::uint32_t* source) noexcept {
        return {_mm256_loadu_si256(reinterpret_cast<const __m256i*>(source))};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Int8 filled(std::uint32_t value) noexcept {
        return {_mm256_set1_epi32(static_cast<int>(value))};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Int8 bits_of(Float8 value) noexcept {
        return {_mm256_castps_si256(value.lanes)};
    }
    /// 0, 1, 2 and so on.
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Int8 lane_numbers() noexcept {
        return {_mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7)};
    }
    CLBVH_ALWAYS_INLINE void store(std::uint32_t* target) const noexcept {
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(target), lanes);
    }
    [[nodiscard]] CLBVH_ALWAYS_INLINE std::uint32_t first() const noexcept {
        return static_cast<std::uint32_t>(_mm256_cvtsi256_si32(lanes));
    }

    friend CLBVH_ALWAYS_INLINE Int8 operator+(Int8 a, Int8 b) noexcept { return {_mm256_add_epi32(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Int8 operator-(Int8 a, Int8 b) noexcept { return {_mm256_sub_epi32(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Int8 operator&(Int8 a, Int8 b) noexcept { return {_mm256_and_si256(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Int8 operator|(Int8 a, Int8 b) noexcept { return {_mm256_or_si256(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Int8 operator^(Int8 a, Int8 b) noexcept { return {_mm256_xor_si256(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Int8 min(Int8 a, Int8 b) noexcept { return {_mm256_min_epi32(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Int8 max(Int8 a, Int8 b) noexcept { return {_mm256_max_epi32(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Mask8 less(Int8 a, Int8 b) noexcept {
        return {_mm256_castsi256_ps(_mm256_cmpgt_epi32(b.lanes, a.lanes))};
    }
    friend CLBVH_ALWAYS_INLINE Mask8 equal(Int8 a, Int8 b) noexcept {
        return {_mm256_castsi256_ps(_mm256_cmpeq_epi32(a.lanes, b.lanes))};
    }
    /// `a` where a < end, else a - end.
    friend CLBVH_ALWAYS_INLINE Int8 wrapped(Int8 a, std::uint32_t end) noexcept {
        const __m256i beyond = _mm256_cmpgt_epi32(a.lanes, filled(end - 1).lanes);
        return {_mm256_sub_epi32(a.lanes, _mm256_and_si256(beyond, filled(end).lanes))};
    }
    friend CLBVH_ALWAYS_INLINE Int8 select(Mask8 mask, Int8 a, Int8 b) noexcept {
        return {_mm256_blendv_epi8(b.lanes, a.lanes, _mm256_castps_si256(mask.lanes))};
    }
    /// Lane i of the result is lane from[i] of `values`.
    friend CLBVH_ALWAYS_INLINE Float8 permuted(Float8 values, Int8 from) noexcept {
        return {_mm256_permutevar8x32_ps(values.lanes, from.lanes)};
    }
    friend CLBVH_ALWAYS_INLINE Int8 permuted(Int8 values, Int8 from) noexcept {
        return {_mm256_permutevar8x32_epi32(values.lanes, from.lanes)};
    }
};

CLBVH_ALWAYS_INLINE Mask8 Float8::only_lane(std::uint32_t lane) noexcept {
    return equal(Int8::lane_numbers(), Int8::filled(lane));
}

struct Set {
    using Float4 = sse2::Float4;
    using Int4 = sse2::Int4;
    using Float8 = avx2::Float8;
    using Widest = Float8;
};

}  // namespace clbvh::simd::avx2
