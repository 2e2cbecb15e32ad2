#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "host/top_down/binned_move.hpp"
#include "host/top_down/binning.hpp"

namespace clbvh::host {

/// The loops of binned builders, compiled for one instruction set.
struct BinningLoops {
    /// See BinSet::add; `rows` are its rows.
    void (*add_references)(BinRow* rows, std::span<const Reference> references, const Binning& binning) noexcept;
    /// See BinSet::find_split.
    BinnedSplit (*find_border)(const BinRow* rows, std::uint32_t row_count, float unit) noexcept;
    /// See find_split_of_few.
    BinnedSplit (*find_border_of_few)(std::span<const Reference> references, const Binning& binning,
                                      float unit) noexcept;
    /// See move_references.
    std::uint32_t (*move)(std::span<const Reference> range, const Binning& binning, const BinnedSplit& split,
                          Reference* left, Reference* right, Sides& sides) noexcept;
};

/// Those of simd::instruction_set().
[[nodiscard]] const BinningLoops& binning_loops() noexcept;

/// Those for AVX2 where the library is compiled for it.
extern const BinningLoops kBinningLoopsAvx2;

/// A row of bins that hold nothing.
inline constexpr BinRow kEmptyRow = [] {
    BinRow row{};
    for (auto& box : row.boxes)
        for (const std::size_t lane : {0u, 1u, 2u, 4u, 5u, 6u})
            box[lane] = std::numeric_limits<float>::infinity();
    return row;
}();

}  // namespace clbvh::host
