#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/simd/float4.hpp"

// Bounds of up to eight boxes along one axis, rounded outwards to a grid of 256 places: origin + q * 2^exponent.
// All of this is exact: where a difference of floats is rounded, what was rounded away decides.
namespace clbvh::layout {

/// The lower and upper bounds of eight boxes along one axis.
struct AxisBounds {
    alignas(16) std::array<float, 8> lower, upper;
};

/// The same on the grid.
struct QuantizedAxis {
    float origin = 0.0f;
    std::int8_t exponent = 0;
    std::array<std::uint8_t, 8> lower{}, upper{};
};

/// rounded + error is a - b, exactly: Knuth's two-sum.
template <typename Number>
struct ExactDifference {
    ExactDifference(Number a, Number b) : rounded(a - b) {
        const Number minus_b = rounded - a;
        error = (a - (rounded - minus_b)) - (b + minus_b);
    }
    Number rounded, error;
};

inline constexpr int kLeastExponent = -126;
inline constexpr int kMostExponent = 127;

/// 2^exponent, for those that floats have without loss of bits.
[[nodiscard]] inline float power_of_two(int exponent) noexcept {
    return std::bit_cast<float>(static_cast<std::uint32_t>(exponent + 127) << 23U);
}

/// The least exponent with extent <= 255 * 2^exponent.
[[nodiscard]] inline int exponent_for(const ExactDifference<float>& extent) noexcept {
    const auto biased = static_cast<int>(std::bit_cast<std::uint32_t>(extent.rounded) >> 23U & 0xFFU);
    for (int exponent = std::clamp(biased - 127 - 7, kLeastExponent, kMostExponent); exponent < kMostExponent;
         ++exponent) {
        const float most = 255.0f * power_of_two(exponent);
        if (extent.rounded < most || (extent.rounded == most && extent.error <= 0.0f)) return exponent;
    }
    return kMostExponent;
}

/// One grid, and four bounds at a time.
class GridRounding {
public:
    GridRounding(float origin, int exponent)
        : origin_(Float4::filled(origin)),
          step_(Float4::filled(power_of_two(exponent))),
          inverse_step_(Float4::filled(power_of_two(std::clamp(-exponent, kLeastExponent, kMostExponent)))) {}

    void round_down(const float* bounds, std::uint8_t* q) const noexcept {
        const Places places = find(bounds);
        store(places.q - select(less(places.beyond, Float4::filled(0.0f)), Float4::filled(1.0f), Float4::filled(0.0f)),
              q);
    }
    void round_up(const float* bounds, std::uint8_t* q) const noexcept {
        const Places places = find(bounds);
        store(places.q + select(less(Float4::filled(0.0f), places.beyond), Float4::filled(1.0f), Float4::filled(0.0f)),
              q);
    }

private:
    /// The last plane that is not behind the rounded distance, and a number of the sign of the exact distance to it.
    struct Places {
        Float4 q, beyond;
    };

    [[nodiscard]] Places find(const float* bounds) const noexcept {
        const ExactDifference<Float4> distance(Float4::load(bounds), origin_);
        const Float4 zero = Float4::filled(0.0f);
        const Float4 steps = min(max(distance.rounded * inverse_step_, zero), Float4::filled(255.0f));
        alignas(16) std::array<std::int32_t, 4> whole;
        steps.truncate(whole.data());
        const Float4 q = Int4::load(whole.data()).to_float();
        const Float4 at_q = q * step_;
        return {q, select(equal(at_q, distance.rounded), distance.error, distance.rounded - at_q)};
    }

    static void store(Float4 q, std::uint8_t* target) noexcept {
        alignas(16) std::array<std::int32_t, 4> whole;
        q.truncate(whole.data());
        for (std::size_t i = 0; i < 4; ++i)
            target[i] = static_cast<std::uint8_t>(whole[i]);
    }

    Float4 origin_, step_, inverse_step_;
};

/// Bounds are finite, and `lower` not above `upper`; others give bounds that mean nothing.
[[nodiscard]] inline QuantizedAxis quantize(const AxisBounds& bounds) noexcept {
    const float* const lower = bounds.lower.data();
    const float* const upper = bounds.upper.data();
    QuantizedAxis result;
    result.origin = min(Float4::load(lower), Float4::load(lower + 4)).least();
    const float highest = -max(Float4::load(upper), Float4::load(upper + 4)).negated().least();
    const int exponent = exponent_for(ExactDifference<float>(highest, result.origin));
    result.exponent = static_cast<std::int8_t>(exponent);
    const GridRounding grid(result.origin, exponent);
    for (std::size_t begin = 0; begin < 8; begin += 4) {
        grid.round_down(lower + begin, result.lower.data() + begin);
        grid.round_up(upper + begin, result.upper.data() + begin);
    }
    return result;
}

}  // namespace clbvh::layout
