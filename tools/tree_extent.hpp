#pragma once

#include <clbvh/core/bvh.hpp>
#include <cstdint>

namespace clbvh::tool {

/// The size of a tree, counted without proving it right.
struct TreeExtent {
    std::uint32_t depth = 0;  ///< Edges on the longest path from the root to a leaf.
    std::uint64_t nodes = 0;
    std::uint64_t leaves = 0;
    std::uint64_t references = 0;  ///< Primitives of all leaves together.
};

/// Throws Error(device_failure) where the nodes cannot be a tree: a child out of range, or more visits than nodes.
[[nodiscard]] TreeExtent measure_extent(const Bvh& bvh);

}  // namespace clbvh::tool
