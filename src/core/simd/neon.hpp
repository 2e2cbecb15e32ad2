#pragma once

#include <arm_neon.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "core/simd/always_inline.hpp"
#include "core/simd/pair.hpp"

/// The vectors of NEON, which every aarch64 has. scalar.hpp says what each function does. NEON's own minimum and
/// maximum treat NaN and zeros in another way than that, so both are a comparison and a selection.
namespace clbvh::simd::neon {

struct Mask4 {
    uint32x4_t lanes;

    [[nodiscard]] CLBVH_ALWAYS_INLINE std::uint32_t bits() const noexcept {
        constexpr uint32x4_t weights = {1, 2, 4, 8};
        return vaddvq_u32(vandq_u32(lanes, weights));
    }
    friend CLBVH_ALWAYS_INLINE Mask4 operator|(Mask4 a, Mask4 b) noexcept { return {vorrq_u32(a.lanes, b.lanes)}; }
};

struct Float4 {
    static constexpr std::uint32_t kCount = 4;
    using Mask = Mask4;

    float32x4_t lanes;

    [[nodiscard]] static CLBVH_ALWAYS_INLINE Float4 load(const float* source) noexcept {
        Float4 loaded;
        std::memcpy(&loaded.lanes, static_cast<const void*>(source), sizeof(loaded.lanes));
        return loaded;
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Float4 load_aligned(const float* source) noexcept { return load(source); }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Float4 filled(float value) noexcept { return {vdupq_n_f32(value)}; }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Float4 filled_with_bits(std::uint32_t bits) noexcept {
        return {vreinterpretq_f32_u32(vdupq_n_u32(bits))};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Float4 of(float x, float y, float z) noexcept {
        return {float32x4_t{x, y, z, 0.0f}};
    }
    CLBVH_ALWAYS_INLINE void store(float* target) const noexcept {
        std::memcpy(static_cast<void*>(target), &lanes, sizeof(lanes));
    }
    CLBVH_ALWAYS_INLINE void store_aligned(float* target) const noexcept { store(target); }
    CLBVH_ALWAYS_INLINE void store_first(std::uint32_t count, float* target) const noexcept {
        select(first_lanes(count), *this, load(target)).store(target);
    }

    [[nodiscard]] CLBVH_ALWAYS_INLINE float x() const noexcept { return vgetq_lane_f32(lanes, 0); }
    [[nodiscard]] CLBVH_ALWAYS_INLINE float y() const noexcept { return vgetq_lane_f32(lanes, 1); }
    [[nodiscard]] CLBVH_ALWAYS_INLINE float z() const noexcept { return vgetq_lane_f32(lanes, 2); }
    [[nodiscard]] CLBVH_ALWAYS_INLINE float least() const noexcept { return vminvq_f32(lanes); }
    [[nodiscard]] CLBVH_ALWAYS_INLINE Float4 negated() const noexcept { return {vnegq_f32(lanes)}; }
    [[nodiscard]] CLBVH_ALWAYS_INLINE Float4 without_w() const noexcept { return {vsetq_lane_f32(0.0f, lanes, 3)}; }
    [[nodiscard]] CLBVH_ALWAYS_INLINE Float4 with_w(std::uint32_t bits) const noexcept {
        return {vreinterpretq_f32_u32(vsetq_lane_u32(bits, vreinterpretq_u32_f32(lanes), 3))};
    }
    CLBVH_ALWAYS_INLINE void truncate(std::int32_t* target) const noexcept { vst1q_s32(target, vcvtq_s32_f32(lanes)); }

    friend CLBVH_ALWAYS_INLINE Float4 operator+(Float4 a, Float4 b) noexcept { return {vaddq_f32(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Float4 operator-(Float4 a, Float4 b) noexcept { return {vsubq_f32(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Float4 operator*(Float4 a, Float4 b) noexcept { return {vmulq_f32(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Float4 operator/(Float4 a, Float4 b) noexcept { return {vdivq_f32(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Float4 min(Float4 a, Float4 b) noexcept { return select(less(a, b), a, b); }
    friend CLBVH_ALWAYS_INLINE Float4 max(Float4 a, Float4 b) noexcept { return select(less(b, a), a, b); }
    friend CLBVH_ALWAYS_INLINE Mask less(Float4 a, Float4 b) noexcept { return {vcltq_f32(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Mask less_equal(Float4 a, Float4 b) noexcept { return {vcleq_f32(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Mask equal(Float4 a, Float4 b) noexcept { return {vceqq_f32(a.lanes, b.lanes)}; }
    friend CLBVH_ALWAYS_INLINE Mask same_bits(Float4 a, Float4 b) noexcept {
        return {vceqq_u32(vreinterpretq_u32_f32(a.lanes), vreinterpretq_u32_f32(b.lanes))};
    }
    friend CLBVH_ALWAYS_INLINE Float4 select(Mask mask, Float4 a, Float4 b) noexcept {
        return {vbslq_f32(mask.lanes, a.lanes, b.lanes)};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Mask first_lanes(std::uint32_t count) noexcept {
        return {vcltq_u32(lane_numbers(), vdupq_n_u32(count))};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Mask only_lane(std::uint32_t lane) noexcept {
        return {vceqq_u32(lane_numbers(), vdupq_n_u32(lane))};
    }
    static CLBVH_ALWAYS_INLINE void transpose(Float4& a, Float4& b, Float4& c) noexcept {
        Float4 unused = c;
        transpose(a, b, c, unused);
    }
    static CLBVH_ALWAYS_INLINE void transpose(Float4& a, Float4& b, Float4& c, Float4& d) noexcept {
        const float32x4x2_t ab = vtrnq_f32(a.lanes, b.lanes);
        const float32x4x2_t cd = vtrnq_f32(c.lanes, d.lanes);
        a.lanes = vcombine_f32(vget_low_f32(ab.val[0]), vget_low_f32(cd.val[0]));
        b.lanes = vcombine_f32(vget_low_f32(ab.val[1]), vget_low_f32(cd.val[1]));
        c.lanes = vcombine_f32(vget_high_f32(ab.val[0]), vget_high_f32(cd.val[0]));
        d.lanes = vcombine_f32(vget_high_f32(ab.val[1]), vget_high_f32(cd.val[1]));
    }

private:
    [[nodiscard]] static CLBVH_ALWAYS_INLINE uint32x4_t lane_numbers() noexcept { return uint32x4_t{0, 1, 2, 3}; }
};

struct Int4 {
    int32x4_t lanes = vdupq_n_s32(0);

    [[nodiscard]] static CLBVH_ALWAYS_INLINE Int4 load(const std::int32_t* source) noexcept {
        return {vld1q_s32(source)};
    }
    friend CLBVH_ALWAYS_INLINE Int4 operator+(Int4 a, Int4 b) noexcept { return {vaddq_s32(a.lanes, b.lanes)}; }
    [[nodiscard]] CLBVH_ALWAYS_INLINE Float4 to_float() const noexcept { return {vcvtq_f32_s32(lanes)}; }
};

struct Double2 {
    float64x2_t lanes;

    [[nodiscard]] static CLBVH_ALWAYS_INLINE Double2 of_x(Float4 a, Float4 b) noexcept {
        return {vcvt_f64_f32(vget_low_f32(vzip1q_f32(a.lanes, b.lanes)))};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Double2 of_y(Float4 a, Float4 b) noexcept {
        return {vcvt_high_f64_f32(vzip1q_f32(a.lanes, b.lanes))};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Double2 of_z(Float4 a, Float4 b) noexcept {
        return {vcvt_f64_f32(vget_low_f32(vzip2q_f32(a.lanes, b.lanes)))};
    }
    CLBVH_ALWAYS_INLINE void store(double* target) const noexcept { vst1q_f64(target, lanes); }
    friend CLBVH_ALWAYS_INLINE Double2 operator+(Double2 a, Double2 b) noexcept {
        return {vaddq_f64(a.lanes, b.lanes)};
    }
    friend CLBVH_ALWAYS_INLINE Double2 operator-(Double2 a, Double2 b) noexcept {
        return {vsubq_f64(a.lanes, b.lanes)};
    }
    friend CLBVH_ALWAYS_INLINE Double2 operator*(Double2 a, Double2 b) noexcept {
        return {vmulq_f64(a.lanes, b.lanes)};
    }
};

struct Set {
    using Float4 = neon::Float4;
    using Int4 = neon::Int4;
    using Float8 = Pair<Float4>;
    using Widest = Float4;
};

}  // namespace clbvh::simd::neon
