#pragma once

#include <cstdint>

#include "clbvh/core/aabb.hpp"

namespace clbvh {

/// SplitMix64 (Steele, Lea, Flood 2014), and numbers made from it that are the same on every platform, which those of
/// the standard's distributions are not.
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}

    /// The `index`-th of the streams that belong to a seed. Neighbouring seeds share none.
    [[nodiscard]] static Random stream(std::uint64_t seed, std::uint64_t index) {
        return Random(Random(seed + Random(index).bits()).bits());
    }

    std::uint64_t bits() {
        state_ += 0x9E3779B97F4A7C15U;
        std::uint64_t z = state_;
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
        return z ^ (z >> 31);
    }

    /// Uniform in [0, 1).
    float unit() { return static_cast<float>(bits() >> 40) * 0x1p-24f; }
    /// Uniform in [low, high).
    float between(float low, float high) { return low + (high - low) * unit(); }
    /// A bell around 0 that ends at -1 and 1.
    float bell() {
        float sum = 0.0f;
        for (int i = 0; i < 4; ++i)
            sum += unit();
        return sum * 0.5f - 1.0f;
    }
    /// Uniform in 0 .. bound - 1.
    std::uint32_t below(std::uint32_t bound) { return static_cast<std::uint32_t>(((bits() >> 32) * bound) >> 32); }

    Vec3 in_cube(float low, float high) {
        const float x = between(low, high);
        const float y = between(low, high);
        const float z = between(low, high);
        return {x, y, z};
    }

private:
    std::uint64_t state_;
};

}  // namespace clbvh
