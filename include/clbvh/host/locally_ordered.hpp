#pragma once

#include <span>

#include "clbvh/core/aabb.hpp"
#include "clbvh/core/bvh.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// Builds by exact greedy agglomerative clustering: always the two clusters whose common box has the least half area
/// merge. Leaves hold one primitive.
///
/// Walter, Bala, Kulkarni, Pingali 2008, "Fast agglomerative clustering for rendering". About O(n log n) time on real
/// scenes; there is no bound below O(n^2) for all input, nor for the depth below n - 1, as with growing nested boxes.
///
/// Builds over `bounds`, where primitive i is bounds[i], on the threads of the calling task arena of oneTBB. Throws
/// Error(invalid_input) where a box is not legal (a NaN, inverted, beyond kMaxCoordinate), naming the first;
/// Error(unsupported) beyond kMaxPrimitives; Error(out_of_memory).
[[nodiscard]] CLBVH_API Bvh build_locally_ordered(std::span<const Aabb> bounds);

}  // namespace clbvh
