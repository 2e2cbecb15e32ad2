#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

namespace clbvh::tool {

/// Numbers for the samples of a pixel. The samples of one pixel cover each pair of dimensions evenly (the additive
/// recurrence with the plastic number, Roberts 2018), from a start that differs from pixel to pixel and from dimension
/// to dimension without a pattern.
class SampleSequence {
public:
    SampleSequence(std::uint64_t seed, std::uint64_t pixel, std::uint32_t sample)
        : start_(mixed(mixed(seed) ^ pixel)), sample_(sample) {}

    /// The next two dimensions, each in [0, 1).
    [[nodiscard]] std::pair<float, float> next() {
        const std::uint64_t bits = mixed(start_ + ++dimension_);
        return {at(bits >> 40, 12664745), at((bits >> 8) & 0xFFFFFFU, 9560333)};
    }
    /// The same in the unit disc, evenly.
    [[nodiscard]] std::pair<float, float> next_in_disc() {
        const auto [x, y] = next();
        const float radius = std::sqrt(x);
        const float angle = 2.0f * std::numbers::pi_v<float> * y;
        return {radius * std::cos(angle), radius * std::sin(angle)};
    }

private:
    /// The finalizer of SplitMix64 (Steele, Lea, Flood 2014).
    static std::uint64_t mixed(std::uint64_t z) {
        z += 0x9E3779B97F4A7C15U;
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
        return z ^ (z >> 31);
    }
    /// In steps of 2^-24; 12664745 and 9560333 of them are 1 / 1.3247 and its square.
    [[nodiscard]] float at(std::uint64_t start, std::uint64_t step) const {
        return static_cast<float>((start + sample_ * step) & 0xFFFFFFU) * 0x1p-24f;
    }

    std::uint64_t start_;
    std::uint64_t sample_;
    std::uint64_t dimension_ = 0;
};

}  // namespace clbvh::tool
