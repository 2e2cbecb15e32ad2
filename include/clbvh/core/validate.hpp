#pragma once

#include <cstdint>
#include <string>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// The result of validate().
struct ValidationReport {
    bool valid = false;
    std::string error;         ///< The first violation in traversal order, structure before boxes; empty where valid.
    std::uint32_t depth = 0;   ///< Edges on the longest path from the root to a leaf.
    std::uint64_t nodes = 0;   ///< Nodes reached from the root.
    std::uint64_t leaves = 0;  ///< Leaves among them.

    explicit operator bool() const noexcept { return valid; }
};

/// Proves that `bvh` is a correct tree over `primitives`: structure as Node documents, every active primitive in
/// exactly one leaf, inactive ones in none, every box equal to the union recomputed from the primitives to the bit
/// (save that -0 equals +0). Primitives that check_primitives refuses make every tree invalid. Never reads out of
/// range, whatever the tree holds. O(n) time and memory.
///
/// Where Bvh::split_references says so, an active primitive is in one leaf or more, but in none twice; a leaf's box
/// lies within the union of its primitives' boxes; and no part of a primitive is lost: the leaves that name it cover it
/// together, boxes to the bit, triangles up to 2^-34 of the largest coordinate, which is a thousandth of what a float
/// can tell apart. That is proven by cutting it, in double precision, into pieces each of which lies in a leaf's box.
/// About O(n log n) time over the trees that builders make.
[[nodiscard]] CLBVH_API ValidationReport validate(const Bvh& bvh, const Primitives& primitives);

}  // namespace clbvh
