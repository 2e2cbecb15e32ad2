#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "host/build/reference.hpp"
#include "kernels/build/cubic_cells.h"

namespace clbvh::host {

/// Bits an axis of the codes of `count` primitives: ceil(log4 count), at least 1. Gu et al. 2013, section 3.1.
[[nodiscard]] constexpr std::uint32_t morton_bits(std::size_t count) noexcept {
    const auto log2 = static_cast<std::uint32_t>(std::bit_width(std::max<std::size_t>(count, 2) - 1));
    return (log2 + 1) / 2;
}

/// Puts two zeros below each of the low 21 bits of `x`.
[[nodiscard]] constexpr std::uint64_t spread_by_3(std::uint64_t x) noexcept {
    x = (x | x << 32) & 0x001f00000000ffffu;
    x = (x | x << 16) & 0x001f0000ff0000ffu;
    x = (x | x << 8) & 0x100f00f00f00f00fu;
    x = (x | x << 4) & 0x10c30c30c30c30c3u;
    return (x | x << 2) & 0x1249249249249249u;
}

/// Puts a zero below each of the low 32 bits of `x`.
[[nodiscard]] constexpr std::uint64_t spread_by_2(std::uint64_t x) noexcept {
    x = (x | x << 16) & 0x0000ffff0000ffffu;
    x = (x | x << 8) & 0x00ff00ff00ff00ffu;
    x = (x | x << 4) & 0x0f0f0f0f0f0f0f0fu;
    x = (x | x << 2) & 0x3333333333333333u;
    return (x | x << 1) & 0x5555555555555555u;
}

/// Maps centroids to their places along a z-order curve through a grid over their bounds.
class MortonGrid {
public:
    /// With cells as cubic as can be, numbered by the leading `bits` bits of 63. `centroid_bounds` are those of doubled
    /// centroids.
    [[nodiscard]] static MortonGrid cubic(const Box4& centroid_bounds, std::uint32_t bits) noexcept {
        const Float4 extents = centroid_bounds.upper - centroid_bounds.lower;
        const float lengths[3] = {extents.x(), extents.y(), extents.z()};
        kernels::CubicCells cells;
        kernels::cut_cells(lengths, kCodeBits, &cells);
        return {centroid_bounds, cells, bits};
    }
    /// With as many cells along each axis: 2^axis_bits, axis_bits being 1 to 21.
    [[nodiscard]] static MortonGrid stretched(const Box4& centroid_bounds, std::uint32_t axis_bits) noexcept {
        kernels::CubicCells cells;
        kernels::stretch_cells(axis_bits, &cells);
        return {centroid_bounds, cells, 3 * axis_bits};
    }

    [[nodiscard]] std::uint64_t code_of(const Reference& reference) const noexcept {
        std::int32_t at[4];
        ((Box4::of(reference).doubled_centroid() - base_) * scale_).truncate(at);
        const std::uint32_t shared = cells_.pairs + cells_.triples;
        const std::uint32_t a = cell(at[cells_.a], cells_.single + shared);
        const std::uint32_t b = cell(at[cells_.b], cells_.odd + shared);
        const std::uint32_t c = cell(at[cells_.c], cells_.triples);
        const std::uint32_t first = cells_.odd != 0 ? a : b;
        const std::uint32_t second = cells_.odd != 0 ? b : a;
        const std::uint64_t upper = std::uint64_t{a >> shared} << cells_.odd | b >> shared;
        const std::uint32_t pair_mask = (1u << cells_.pairs) - 1;
        const std::uint64_t pairs =
            spread_by_2(first >> cells_.triples & pair_mask) << 1 | spread_by_2(second >> cells_.triples & pair_mask);
        const std::uint32_t mask = (1u << cells_.triples) - 1;
        const std::uint64_t code = (upper << 2 * cells_.pairs | pairs) << 3 * cells_.triples | spread_by_3(c) << 2 |
                                   spread_by_3(first & mask) << 1 | spread_by_3(second & mask);
        return code << unused_ >> dropped_;
    }

private:
    static constexpr std::uint32_t kCodeBits = 63;

    MortonGrid(const Box4& centroid_bounds, const kernels::CubicCells& cells, std::uint32_t bits) noexcept
        : base_(centroid_bounds.lower),
          cells_(cells),
          unused_(kCodeBits - kernels::bits_of_cells(&cells)),
          dropped_(kCodeBits - bits) {
        const Float4 extents = centroid_bounds.upper - centroid_bounds.lower;
        const std::uint32_t shared = cells.pairs + cells.triples;
        float count[3];
        count[cells.a] = static_cast<float>(1u << (cells.single + shared));
        count[cells.b] = static_cast<float>(1u << (cells.odd + shared));
        count[cells.c] = static_cast<float>(1u << cells.triples);
        scale_ = Float4::of(scale(count[0], extents.x()), scale(count[1], extents.y()), scale(count[2], extents.z()));
    }

    /// The upper bounds lie in the last of 2^bits cells.
    static std::uint32_t cell(std::int32_t number, std::uint32_t bits) noexcept {
        return std::min(static_cast<std::uint32_t>(number), (1u << bits) - 1);
    }

    /// A denormal extent would make an infinite scale: such an axis counts as one without extent.
    static float scale(float cells, float extent) noexcept {
        const float scale = cells / extent;
        return scale <= std::numeric_limits<float>::max() ? scale : 0.0f;
    }

    Float4 base_;
    Float4 scale_;
    kernels::CubicCells cells_;
    std::uint32_t unused_;   ///< bits of 63 that the cells do not take
    std::uint32_t dropped_;  ///< bits of 63 that are not asked for
};

}  // namespace clbvh::host
