#pragma once

#include <cstdint>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// Top-down builder that halves the primitives at the median centroid along the longest axis of the centroids' bounds.
///
/// The floor that every other builder must beat. O(n log n) time; depth at most ceil(log2 n).
struct MedianConfig {
    std::uint32_t max_leaf_size = 8;  ///< Largest leaf, in primitives, 1 to 64.
};

/// Builds over triangles or boxes, on the threads of the calling task arena of oneTBB. Throws Error(invalid_input)
/// where a field of `config` is out of its range, naming it; what check_primitives throws; Error(out_of_memory).
[[nodiscard]] CLBVH_API Bvh build_median(const Primitives& primitives, const MedianConfig& config = {});

}  // namespace clbvh
