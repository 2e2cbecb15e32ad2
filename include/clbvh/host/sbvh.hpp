#pragma once

#include <cstdint>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// Top-down builder that may cut primitives: at each node the better of an object split and a spatial split.
///
/// Stich, Friedrich, Dietrich 2009, "Spatial splits in bounding volume hierarchies". O(n log n) time; depth at most
/// 288.
struct SbvhConfig {
    std::uint32_t bin_count = 16;          ///< Bins an axis of object splits, over the centroids' bounds, 2 to 64.
    std::uint32_t spatial_bin_count = 16;  ///< Bins an axis of spatial splits, over the node's box, 2 to 64.
    float alpha = 1e-5f;                   ///< Least overlap of the object split's children, relative to the scene's
                                           ///< half area, that makes it try a spatial split, 0 to 1.
    float overlap = 0.0f;                  ///< The same relative to the node's own half area, 0 to 1; 0: alpha alone,
                                           ///< as in the paper.
    float reference_budget = 2.0f;         ///< Most references, as a multiple of the primitives, 1 to 8.
    float inner_cost = 1.2f;               ///< Cost of visiting an inner node, above 0.
    float primitive_cost = 1.0f;           ///< Cost of testing one primitive, above 0.
    std::uint32_t max_leaf_size = 8;       ///< Largest leaf, in primitives, 1 to 64.
};

/// Builds over triangles or boxes, on the threads of the calling task arena of oneTBB. Triangles are cut with their
/// boxes, so that the parts' boxes shrink around what is left; boxes are cut as they are. The tree has
/// Bvh::split_references, save where the budget leaves no reference to spare. Throws Error(invalid_input) where a field
/// of `config` is out of its range, naming it; what check_primitives throws; Error(out_of_memory).
[[nodiscard]] CLBVH_API Bvh build_sbvh(const Primitives& primitives, const SbvhConfig& config = {});

}  // namespace clbvh
