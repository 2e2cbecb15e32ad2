#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "host/build/reference.hpp"

namespace clbvh::host {

/// Bits an axis of the codes of `count` primitives: ceil(log4 count), at least 1. Gu et al. 2013, section 3.1.
[[nodiscard]] constexpr std::uint32_t morton_bits(std::size_t count) noexcept {
    const auto log2 = static_cast<std::uint32_t>(std::bit_width(std::max<std::size_t>(count, 2) - 1));
    return (log2 + 1) / 2;
}

/// Puts two zeros below each of the low 10 bits of `x`.
[[nodiscard]] constexpr std::uint32_t spread_bits(std::uint32_t x) noexcept {
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

/// Puts two zeros below each of the low 21 bits of `x`.
[[nodiscard]] constexpr std::uint64_t spread_bits(std::uint64_t x) noexcept {
    x = (x | x << 32) & 0x001f00000000ffffu;
    x = (x | x << 16) & 0x001f0000ff0000ffu;
    x = (x | x << 8) & 0x100f00f00f00f00fu;
    x = (x | x << 4) & 0x10c30c30c30c30c3u;
    return (x | x << 2) & 0x1249249249249249u;
}

/// Maps centroids to their places along a z-order curve through a grid over their bounds.
class MortonGrid {
public:
    /// `centroid_bounds` are those of doubled centroids; `bits` an axis, 1 to 21. Axes without extent have one cell.
    MortonGrid(const Box4& centroid_bounds, std::uint32_t bits) noexcept : base_(centroid_bounds.lower) {
        const Float4 extents = centroid_bounds.upper - centroid_bounds.lower;
        const auto cells = static_cast<float>(1u << bits);
        last_ = Float4::filled(cells - 1.0f);
        scale_ = Float4::of(scale(cells, extents.x()), scale(cells, extents.y()), scale(cells, extents.z()));
    }

    template <typename Code>
    [[nodiscard]] Code code_of(const Reference& reference) const noexcept {
        std::int32_t cells[4];
        min((Box4::of(reference).doubled_centroid() - base_) * scale_, last_).truncate(cells);
        const auto spread = [](std::int32_t cell) { return spread_bits(static_cast<Code>(cell)); };
        return static_cast<Code>(spread(cells[0]) << 2 | spread(cells[1]) << 1 | spread(cells[2]));
    }

private:
    /// A denormal extent would make an infinite scale: such an axis counts as one without extent.
    static float scale(float cells, float extent) noexcept {
        const float scale = cells / extent;
        return scale <= std::numeric_limits<float>::max() ? scale : 0.0f;
    }

    Float4 base_;
    Float4 scale_;
    Float4 last_;
};

}  // namespace clbvh::host
