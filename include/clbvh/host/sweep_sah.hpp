#pragma once

#include <cstdint>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// Top-down builder that evaluates the surface area heuristic between any two primitives in the order of centroids.
///
/// MacDonald, Booth 1990, "Heuristics for ray tracing using space subdivision"; stable partition of three presorted
/// arrays after Perard-Gayot, "Building (good) BVHs". O(n log n) time; depth at most 288.
struct SweepSahConfig {
    float inner_cost = 1.2f;          ///< Cost of visiting an inner node, above 0.
    float primitive_cost = 1.0f;      ///< Cost of testing one primitive, above 0.
    std::uint32_t max_leaf_size = 8;  ///< Largest leaf, in primitives, 1 to 64.
};

/// Builds over triangles or boxes, on the threads of the calling task arena of oneTBB. Throws Error(invalid_input)
/// where a field of `config` is out of its range, naming it; what check_primitives throws; Error(out_of_memory).
[[nodiscard]] CLBVH_API Bvh build_sweep_sah(const Primitives& primitives, const SweepSahConfig& config = {});

}  // namespace clbvh
