#pragma once

#include <cstdint>
#include <span>

#include "clbvh/core/aabb.hpp"
#include "clbvh/core/bvh.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// Top-down builder that halves the primitives at the median centroid along the longest axis of the centroids' bounds.
///
/// The floor that every other builder must beat. O(n log n) time; depth at most ceil(log2 n).
struct MedianConfig {
    std::uint32_t max_leaf_size = 8;  ///< Largest leaf, in primitives, 1 to 64.
};

/// Builds over `bounds`, where primitive i is bounds[i], on the threads of the calling task arena of oneTBB.
/// Throws Error(invalid_input) where a field of `config` is out of its range, naming it, or a box is not legal (a NaN,
/// inverted, beyond kMaxCoordinate), naming the first; Error(unsupported) beyond kMaxPrimitives; Error(out_of_memory).
[[nodiscard]] CLBVH_API Bvh build_median(std::span<const Aabb> bounds, const MedianConfig& config = {});

}  // namespace clbvh
