#pragma once

#include <cstdint>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// Bottom-up builder that merges the closest clusters, among those that a walk up the Morton order brings together.
///
/// Gu, He, Fatahalian, Blelloch 2013, "Efficient BVH construction via approximate agglomerative clustering". O(n) time
/// for `epsilon` above 0; depth at most n - 1.
struct AacConfig {
    std::uint32_t delta = 20;     ///< Fewer primitives than this are clustered without a look at the code, 2 to 64.
    float epsilon = 0.1f;         ///< n primitives are reduced to delta^(0.5 + epsilon) / 2 * n^(0.5 - epsilon)
                                  ///< clusters before they meet others, 0 to 0.5.
    float inner_cost = 1.2f;      ///< Cost of visiting a node, above 0; for flattening.
    float primitive_cost = 1.0f;  ///< Cost of testing one primitive, above 0; for flattening.
    bool cubic_cells = true;      ///< Cells of the code are as cubic as can be, and where more than a few primitives
                                  ///< share one they get codes within their own bounds; else cells are stretched as
                                  ///< the scene is, as the paper has it.
    std::uint32_t max_leaf_size = 8;  ///< Largest leaf, in primitives, 1 to 64. 1: no subtree is flattened.

    /// The paper's AAC-HQ: for quality.
    [[nodiscard]] static constexpr AacConfig hq() noexcept { return {}; }
    /// The paper's AAC-Fast.
    [[nodiscard]] static constexpr AacConfig fast() noexcept {
        AacConfig config;
        config.delta = 4;
        config.epsilon = 0.2f;
        return config;
    }
};

/// Builds over triangles or boxes, on the threads of the calling task arena of oneTBB. Throws Error(invalid_input)
/// where a field of `config` is out of its range, naming it; what check_primitives throws; Error(out_of_memory).
[[nodiscard]] CLBVH_API Bvh build_aac(const Primitives& primitives, const AacConfig& config = {});

}  // namespace clbvh
