#pragma once

#include <cstdint>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"
#include "clbvh/layout/node_opening.hpp"

namespace clbvh {

/// How a layout is made.
struct LayoutOptions {
    std::uint32_t thread_count = 0;  ///< 1 to 1024; 0: all.
    /// False for a tree that is known to be one over these primitives, as a builder's is: what is wrong with another
    /// then goes unnoticed, and the behaviour is undefined.
    bool check = true;
    NodeOpening opening = NodeOpening::largest_first;  ///< Of Wide8, Wide4 and Compressed8; others keep all nodes.
};

/// A new layout of a tree over triangles: make_layout<clbvh::Wide8>(bvh, mesh).
template <typename Layout>
[[nodiscard]] Layout make_layout(const Bvh& bvh, const MeshView& mesh, const LayoutOptions& options = {}) {
    Layout result;
    make_layout(bvh, mesh, result, options);
    return result;
}

/// The same where the layout holds nothing of the primitives: make_layout<clbvh::SkipLayout>(bvh).
template <typename Layout>
[[nodiscard]] Layout make_layout(const Bvh& bvh, const LayoutOptions& options = {}) {
    Layout result;
    make_layout(bvh, result, options);
    return result;
}

}  // namespace clbvh
