#pragma once

#include <cstdint>

#include "clbvh/core/bvh.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// Merges subtrees into leaves, bottom-up, wherever that lowers the tree's SAH cost.
///
/// The last step of Karras, Aila 2013, "Fast parallel construction of high-quality bounding volume hierarchies", and of
/// the comparison in Benthin et al. 2022: of all ways to cut subtrees off, the one of least cost. O(n) time.
struct CollapseConfig {
    std::uint32_t max_leaf_size = 8;  ///< Largest merged leaf, in primitives, 1 to 64.
    float inner_cost = 1.2f;          ///< Cost of visiting an inner node, above 0.
    float primitive_cost = 1.0f;      ///< Cost of testing one primitive, above 0.
};

/// Collapses `tree`, on the threads of the calling task arena of oneTBB; the result is depth first, without holes, and
/// the same on any number of threads. It takes every tree that validate() accepts, of any numbering and depth. Leaves
/// of `tree` stay whole, be they larger than max_leaf_size. A primitive that a merged leaf would hold twice, which only
/// trees with split_references can have, is kept and counted once; subtrees of more than 256 ids are not merged.
/// Throws Error(invalid_input) where a field of `config` is out of its range, naming it; Error(out_of_memory).
[[nodiscard]] CLBVH_API Bvh collapse(const Bvh& tree, const CollapseConfig& config = {});

}  // namespace clbvh
