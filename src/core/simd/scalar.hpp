#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

#include "core/simd/pair.hpp"

/// The vectors of the library without any instructions for them: what the other sets have to equal, to the bit.
/// Every set has Float4, Int4 and Double2, and in its Set the widths that kernels are written for.
namespace clbvh::simd::scalar {

/// The outcome of a comparison, lane by lane.
template <std::uint32_t Count>
struct Masks {
    std::array<bool, Count> lanes;

    /// Bit i for lane i.
    [[nodiscard]] std::uint32_t bits() const noexcept {
        std::uint32_t bits = 0;
        for (std::uint32_t i = 0; i < Count; ++i)
            bits |= (lanes[i] ? 1u : 0u) << i;
        return bits;
    }
    friend Masks operator|(Masks a, const Masks& b) noexcept {
        for (std::uint32_t i = 0; i < Count; ++i)
            a.lanes[i] = a.lanes[i] || b.lanes[i];
        return a;
    }
};

template <std::uint32_t Count>
struct Floats {
    static constexpr std::uint32_t kCount = Count;
    using Mask = Masks<Count>;

    std::array<float, Count> lanes;

    /// Also of words that are no floats, to be moved and compared by same_bits.
    [[nodiscard]] static Floats load(const float* source) noexcept {
        Floats loaded;
        std::memcpy(&loaded.lanes, static_cast<const void*>(source), sizeof(loaded.lanes));
        return loaded;
    }
    /// `source` is a multiple of the size of the vector.
    [[nodiscard]] static Floats load_aligned(const float* source) noexcept { return load(source); }
    [[nodiscard]] static Floats filled(float value) noexcept {
        Floats filled;
        filled.lanes.fill(value);
        return filled;
    }
    [[nodiscard]] static Floats filled_with_bits(std::uint32_t bits) noexcept {
        return filled(std::bit_cast<float>(bits));
    }
    /// The fourth lane is 0.
    [[nodiscard]] static Floats of(float x, float y, float z) noexcept { return {{x, y, z, 0.0f}}; }
    void store(float* target) const noexcept { std::memcpy(static_cast<void*>(target), &lanes, sizeof(lanes)); }
    void store_aligned(float* target) const noexcept { store(target); }
    /// Stores the first `count` lanes, at least one; further ones may be written as they were.
    void store_first(std::uint32_t count, float* target) const noexcept {
        for (std::uint32_t i = 0; i < Count && i < count; ++i)
            std::memcpy(static_cast<void*>(target + i), &lanes[i], sizeof(float));
    }

    [[nodiscard]] float x() const noexcept { return lanes[0]; }
    [[nodiscard]] float y() const noexcept { return lanes[1]; }
    [[nodiscard]] float z() const noexcept { return lanes[2]; }
    /// The least of all lanes, none of which is NaN.
    [[nodiscard]] float least() const noexcept {
        float least = lanes[0];
        for (std::uint32_t i = 1; i < Count; ++i)
            least = lanes[i] < least ? lanes[i] : least;
        return least;
    }
    [[nodiscard]] Floats negated() const noexcept {
        Floats negated;
        for (std::uint32_t i = 0; i < Count; ++i)
            negated.lanes[i] = -lanes[i];
        return negated;
    }
    /// The same with 0 in the fourth lane, where bits of an integer may stand that would be slow to calculate with.
    [[nodiscard]] Floats without_w() const noexcept { return {{lanes[0], lanes[1], lanes[2], 0.0f}}; }
    /// The same with the bits of an integer in the fourth lane.
    [[nodiscard]] Floats with_w(std::uint32_t bits) const noexcept {
        return {{lanes[0], lanes[1], lanes[2], std::bit_cast<float>(bits)}};
    }
    /// Each lane rounded towards zero; of no meaning where that is no std::int32_t.
    void truncate(std::int32_t* target) const noexcept {
        constexpr float end = 0x1p31f;
        for (std::uint32_t i = 0; i < Count; ++i)
            target[i] = lanes[i] >= -end && lanes[i] < end ? static_cast<std::int32_t>(lanes[i]) : INT32_MIN;
    }

    template <typename Operation>
    [[nodiscard]] static Floats lane_by_lane(const Floats& a, const Floats& b, Operation operation) noexcept {
        Floats result;
        for (std::uint32_t i = 0; i < Count; ++i)
            result.lanes[i] = operation(a.lanes[i], b.lanes[i]);
        return result;
    }
    template <typename Comparison>
    [[nodiscard]] static Mask compared(const Floats& a, const Floats& b, Comparison comparison) noexcept {
        Mask mask;
        for (std::uint32_t i = 0; i < Count; ++i)
            mask.lanes[i] = comparison(a.lanes[i], b.lanes[i]);
        return mask;
    }

    friend Floats operator+(const Floats& a, const Floats& b) noexcept {
        return lane_by_lane(a, b, [](float x, float y) { return x + y; });
    }
    friend Floats operator-(const Floats& a, const Floats& b) noexcept {
        return lane_by_lane(a, b, [](float x, float y) { return x - y; });
    }
    friend Floats operator*(const Floats& a, const Floats& b) noexcept {
        return lane_by_lane(a, b, [](float x, float y) { return x * y; });
    }
    friend Floats operator/(const Floats& a, const Floats& b) noexcept {
        return lane_by_lane(a, b, [](float x, float y) { return x / y; });
    }
    /// The second one where one is NaN, or where both are 0; max too.
    friend Floats min(const Floats& a, const Floats& b) noexcept {
        return lane_by_lane(a, b, [](float x, float y) { return x < y ? x : y; });
    }
    friend Floats max(const Floats& a, const Floats& b) noexcept {
        return lane_by_lane(a, b, [](float x, float y) { return x > y ? x : y; });
    }
    friend Mask less(const Floats& a, const Floats& b) noexcept {
        return compared(a, b, [](float x, float y) { return x < y; });
    }
    friend Mask less_equal(const Floats& a, const Floats& b) noexcept {
        return compared(a, b, [](float x, float y) { return x <= y; });
    }
    friend Mask equal(const Floats& a, const Floats& b) noexcept {
        return compared(a, b, [](float x, float y) { return x == y; });
    }
    friend Mask same_bits(const Floats& a, const Floats& b) noexcept {
        return compared(
            a, b, [](float x, float y) { return std::bit_cast<std::uint32_t>(x) == std::bit_cast<std::uint32_t>(y); });
    }
    /// Lane by lane, `a` where the mask is set, else `b`.
    friend Floats select(const Mask& mask, const Floats& a, Floats b) noexcept {
        for (std::uint32_t i = 0; i < Count; ++i)
            b.lanes[i] = mask.lanes[i] ? a.lanes[i] : b.lanes[i];
        return b;
    }
    [[nodiscard]] static Mask first_lanes(std::uint32_t count) noexcept {
        Mask mask;
        for (std::uint32_t i = 0; i < Count; ++i)
            mask.lanes[i] = i < count;
        return mask;
    }
    /// None where there is no such lane.
    [[nodiscard]] static Mask only_lane(std::uint32_t lane) noexcept {
        Mask mask;
        for (std::uint32_t i = 0; i < Count; ++i)
            mask.lanes[i] = i == lane;
        return mask;
    }
    /// The first lanes of `a`, `b` and `c`, then the second ones, then the third ones; fourth lanes are of no meaning.
    static void transpose(Floats& a, Floats& b, Floats& c) noexcept {
        std::swap(a.lanes[1], b.lanes[0]);
        std::swap(a.lanes[2], c.lanes[0]);
        std::swap(b.lanes[2], c.lanes[1]);
    }
    /// The first lanes of all four, then the second ones, and so on.
    static void transpose(Floats& a, Floats& b, Floats& c, Floats& d) noexcept {
        transpose(a, b, c);
        std::swap(a.lanes[3], d.lanes[0]);
        std::swap(b.lanes[3], d.lanes[1]);
        std::swap(c.lanes[3], d.lanes[2]);
    }
};

using Float4 = Floats<4>;

/// Four integers that are counted with.
struct Int4 {
    std::array<std::int32_t, 4> lanes{};

    [[nodiscard]] static Int4 load(const std::int32_t* source) noexcept {
        return {{source[0], source[1], source[2], source[3]}};
    }
    friend Int4 operator+(Int4 a, const Int4& b) noexcept {
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
};

/// The same lane of two vectors, in double precision.
struct Double2 {
    std::array<double, 2> lanes;

    [[nodiscard]] static Double2 of_x(const Float4& a, const Float4& b) noexcept { return {{a.x(), b.x()}}; }
    [[nodiscard]] static Double2 of_y(const Float4& a, const Float4& b) noexcept { return {{a.y(), b.y()}}; }
    [[nodiscard]] static Double2 of_z(const Float4& a, const Float4& b) noexcept { return {{a.z(), b.z()}}; }
    void store(double* target) const noexcept { std::memcpy(target, &lanes, sizeof(lanes)); }
    friend Double2 operator+(const Double2& a, const Double2& b) noexcept {
        return {{a.lanes[0] + b.lanes[0], a.lanes[1] + b.lanes[1]}};
    }
    friend Double2 operator-(const Double2& a, const Double2& b) noexcept {
        return {{a.lanes[0] - b.lanes[0], a.lanes[1] - b.lanes[1]}};
    }
    friend Double2 operator*(const Double2& a, const Double2& b) noexcept {
        return {{a.lanes[0] * b.lanes[0], a.lanes[1] * b.lanes[1]}};
    }
};

struct Set {
    using Float4 = scalar::Float4;
    using Int4 = scalar::Int4;
    using Float8 = Pair<Float4>;
    using Widest = Floats<1>;
};

}  // namespace clbvh::simd::scalar
