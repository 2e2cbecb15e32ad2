#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "host/top_down/binning.hpp"

namespace clbvh::host {

/// References to the left and to the right of a split.
using Sides = std::array<Bounds, 2>;

/// Copies the lefts of `range` to `left` ascending and its rights to below `right` descending, without a branch on the
/// side, and adds them to `sides`. Returns the number of lefts.
std::uint32_t move_references(std::span<const Reference> range, const Binning& binning, const BinnedSplit& split,
                              Reference* left, Reference* right, Sides& sides) noexcept;

}  // namespace clbvh::host
