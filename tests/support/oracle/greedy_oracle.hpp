#pragma once

#include <span>
#include <string>

#include "clbvh/core/bvh.hpp"

namespace clbvh::test {

/// Proves that greedy agglomerative clustering of `boxes` may have made `bvh`, a valid tree with one primitive in each
/// leaf: its merges are replayed in the order of their half areas, and each of them must join a closest pair of all
/// clusters there are at that time. Where distances are equal, any of the closest pairs will do. Returns what the first
/// wrong merge is, or nothing. O(n^2) time where few clusters share a nearest one.
[[nodiscard]] std::string check_greedy(const Bvh& bvh, std::span<const Aabb> boxes);

}  // namespace clbvh::test
