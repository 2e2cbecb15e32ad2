#pragma once

#include <cstdint>

#include "core/simd/always_inline.hpp"

namespace clbvh::simd {

/// Eight floats in two vectors of four, for sets that have no wider ones.
template <typename Half>
struct Pair {
    static constexpr std::uint32_t kCount = 2 * Half::kCount;

    Half low, high;

    struct Mask {
        typename Half::Mask low, high;

        [[nodiscard]] CLBVH_ALWAYS_INLINE std::uint32_t bits() const noexcept {
            return low.bits() | high.bits() << Half::kCount;
        }
        friend CLBVH_ALWAYS_INLINE Mask operator|(const Mask& a, const Mask& b) noexcept {
            return {a.low | b.low, a.high | b.high};
        }
    };

    [[nodiscard]] static CLBVH_ALWAYS_INLINE Pair load(const float* source) noexcept {
        return {Half::load(source), Half::load(source + Half::kCount)};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Pair load_aligned(const float* source) noexcept {
        return {Half::load_aligned(source), Half::load_aligned(source + Half::kCount)};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Pair filled(float value) noexcept {
        return {Half::filled(value), Half::filled(value)};
    }
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Pair of_halves(const Half& low, const Half& high) noexcept {
        return {low, high};
    }
    CLBVH_ALWAYS_INLINE void store(float* target) const noexcept {
        low.store(target);
        high.store(target + Half::kCount);
    }
    CLBVH_ALWAYS_INLINE void store_aligned(float* target) const noexcept {
        low.store_aligned(target);
        high.store_aligned(target + Half::kCount);
    }
    [[nodiscard]] CLBVH_ALWAYS_INLINE Half low_half() const noexcept { return low; }
    [[nodiscard]] CLBVH_ALWAYS_INLINE Half high_half() const noexcept { return high; }
    /// The same with the sign of the last four lanes turned.
    [[nodiscard]] CLBVH_ALWAYS_INLINE Pair with_negated_high_half() const noexcept { return {low, high.negated()}; }

    friend CLBVH_ALWAYS_INLINE Pair operator+(const Pair& a, const Pair& b) noexcept {
        return {a.low + b.low, a.high + b.high};
    }
    friend CLBVH_ALWAYS_INLINE Pair operator-(const Pair& a, const Pair& b) noexcept {
        return {a.low - b.low, a.high - b.high};
    }
    friend CLBVH_ALWAYS_INLINE Pair operator*(const Pair& a, const Pair& b) noexcept {
        return {a.low * b.low, a.high * b.high};
    }
    friend CLBVH_ALWAYS_INLINE Pair operator/(const Pair& a, const Pair& b) noexcept {
        return {a.low / b.low, a.high / b.high};
    }
    friend CLBVH_ALWAYS_INLINE Pair min(const Pair& a, const Pair& b) noexcept {
        return {min(a.low, b.low), min(a.high, b.high)};
    }
    friend CLBVH_ALWAYS_INLINE Pair max(const Pair& a, const Pair& b) noexcept {
        return {max(a.low, b.low), max(a.high, b.high)};
    }
    friend CLBVH_ALWAYS_INLINE Mask less(const Pair& a, const Pair& b) noexcept {
        return {less(a.low, b.low), less(a.high, b.high)};
    }
    friend CLBVH_ALWAYS_INLINE Mask equal(const Pair& a, const Pair& b) noexcept {
        return {equal(a.low, b.low), equal(a.high, b.high)};
    }
    friend CLBVH_ALWAYS_INLINE Pair select(const Mask& mask, const Pair& a, const Pair& b) noexcept {
        return {select(mask.low, a.low, b.low), select(mask.high, a.high, b.high)};
    }
    friend CLBVH_ALWAYS_INLINE Mask less_equal(const Pair& a, const Pair& b) noexcept {
        return {less_equal(a.low, b.low), less_equal(a.high, b.high)};
    }
};

}  // namespace clbvh::simd
