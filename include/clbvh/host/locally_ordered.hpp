#pragma once

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// Builds by exact greedy agglomerative clustering: always the two clusters whose common box has the least half area
/// merge. Leaves hold one primitive.
///
/// Walter, Bala, Kulkarni, Pingali 2008, "Fast agglomerative clustering for rendering". About O(n log n) time on real
/// scenes; there is no bound below O(n^2) for all input, nor for the depth below n - 1, as with growing nested boxes.
///
/// Builds over triangles or boxes, on the threads of the calling task arena of oneTBB. Throws what check_primitives
/// throws; Error(out_of_memory).
[[nodiscard]] CLBVH_API Bvh build_locally_ordered(const Primitives& primitives);

}  // namespace clbvh
