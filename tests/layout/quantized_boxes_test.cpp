#include "layout/quantized_boxes.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/random.hpp"

using namespace clbvh;
using namespace clbvh::layout;

namespace {

__extension__ typedef __int128 Wide;  // NOLINT(modernize-use-using): clang takes no other

/// `value` * 2^85, exactly, where it is 0 or from 2^-61 to below 2^40. All else is a step of a grid over no extent:
/// less than any difference, and more than 0.
Wide scaled(double value) {
    int exponent = 0;
    const auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(value, &exponent), 24));
    const int shift = exponent - 24 + 85;
    if (value == 0.0) return 0;
    if (shift >= 0) return Wide{mantissa} * (Wide{1} << shift);
    REQUIRE((value > 0.0 && exponent < -85));
    return 1;
}

Wide plane(const QuantizedAxis& axis, int q) {
    return scaled(axis.origin) + (q == 0 ? Wide{0} : scaled(std::ldexp(q, axis.exponent)));
}

/// Proves that bounds lie within their planes, and that no plane, and no finer grid, would have been closer.
void check(const AxisBounds& bounds) {
    const QuantizedAxis axis = quantize(bounds);
    Wide highest = scaled(bounds.upper[0]);
    for (std::size_t i = 0; i < 8; ++i) {
        const Wide lower = scaled(bounds.lower[i]), upper = scaled(bounds.upper[i]);
        highest = std::max(highest, upper);
        REQUIRE(plane(axis, axis.lower[i]) <= lower);
        REQUIRE(plane(axis, axis.upper[i]) >= upper);
        REQUIRE((axis.lower[i] == 255 || plane(axis, axis.lower[i] + 1) > lower));
        REQUIRE((axis.upper[i] == 0 || plane(axis, axis.upper[i] - 1) < upper));
    }
    if (axis.exponent == kLeastExponent) return;
    QuantizedAxis finer = axis;
    --finer.exponent;
    REQUIRE(plane(finer, 255) < highest);
}

}  // namespace

TEST_CASE("quantized boxes: bounds are rounded outwards, no further than to the next plane, on the finest grid") {
    Random random(3);
    for (std::uint32_t round = 0; round < 20'000; ++round) {
        // Boxes of very different size and place; the largest is far from the origin, or not.
        const float size = std::ldexp(1.0f, static_cast<int>(random.below(40)) - 20);
        const float place =
            std::ldexp(1.0f, static_cast<int>(random.below(40)) - 20) * (random.below(2) == 0 ? -1.0f : 1.0f);
        AxisBounds bounds;
        for (std::size_t i = 0; i < 8; ++i) {
            const float a = place + size * random.unit(), b = place + size * random.unit() * random.unit();
            bounds.lower[i] = std::min(a, b);
            bounds.upper[i] = std::max(a, b);
        }
        check(bounds);
    }
}

TEST_CASE("quantized boxes: differences that floats cannot hold are rounded the right way") {
    const float tiny = std::ldexp(1.0f, -40), below_one = std::nextafter(1.0f, 0.0f);
    for (const float origin : {-tiny, -1.0f, -below_one, tiny, 0.0f, 1.0f}) {
        for (const float x : {tiny, below_one, 1.0f, std::nextafter(1.0f, 2.0f), 255.0f, std::nextafter(255.0f, 0.0f),
                              std::nextafter(255.0f, 256.0f), 254.0f, 256.0f, 3.0f, 1e9f}) {
            if (x < origin) continue;
            AxisBounds bounds;
            bounds.lower.fill(x);
            bounds.upper.fill(x);
            bounds.lower[3] = origin;
            bounds.lower[5] = std::max(origin, std::nextafter(x, origin));
            check(bounds);
        }
    }
}

TEST_CASE("quantized boxes: an axis without an extent has one plane") {
    AxisBounds bounds;
    bounds.lower.fill(-3.25f);
    bounds.upper.fill(-3.25f);
    const QuantizedAxis axis = quantize(bounds);
    CHECK(axis.origin == -3.25f);
    CHECK(axis.lower == std::array<std::uint8_t, 8>{});
    CHECK(axis.upper == std::array<std::uint8_t, 8>{});
    CHECK(axis.exponent == kLeastExponent);
}

TEST_CASE("quantized boxes: numbers without all bits, and at the limit of coordinates") {
    const float least = std::numeric_limits<float>::denorm_min();
    AxisBounds bounds;
    bounds.lower.fill(0.0f);
    bounds.upper.fill(least);
    CHECK(quantize(bounds).upper[0] == 1);
    bounds.upper[7] = 1e18f;
    CHECK(quantize(bounds).upper[0] == 1);
    bounds.lower[1] = -1e18f;
    const QuantizedAxis axis = quantize(bounds);
    CHECK(axis.origin + static_cast<float>(axis.upper[7]) * power_of_two(axis.exponent) >= 1e18f);
}
