#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "host/binning.hpp"

namespace clbvh::host {

/// What lies on one side of a split.
struct Side {
    Box4 box;
    Box4 centroids;  ///< Bounds of the doubled centroids.

    void add(const Reference& reference) noexcept {
        const Box4 reference_box = Box4::of(reference);
        box.merge(reference_box);
        centroids.merge(reference_box.doubled_centroid());
    }
    void add(const Side& side) noexcept {
        box.merge(side.box);
        centroids.merge(side.centroids);
    }
};
using Sides = std::array<Side, 2>;

/// Copies the lefts of `range` to `left` ascending and its rights to below `right` descending, without a branch on the
/// side, and adds them to `sides`. Returns the number of lefts.
std::uint32_t move_references(std::span<const Reference> range, const Binning& binning, const BinnedSplit& split,
                              Reference* left, Reference* right, Sides& sides) noexcept;

}  // namespace clbvh::host
