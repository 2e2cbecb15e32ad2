#pragma once

#include <span>

#include "host/build/reference.hpp"

namespace clbvh::host {

/// Reorders boxes as the leaves of a kd-tree: every aligned block of a power of two of positions holds boxes that lie
/// close together and are of similar size. Ranges are split at the median of that coordinate which spreads most, the
/// doubled centroid or the extent along an axis; the field `primitive`, which is unique, decides between equal ones.
void order_by_kd_tree(std::span<Reference> boxes);

}  // namespace clbvh::host
