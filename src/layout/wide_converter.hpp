#pragma once

#include <cstdint>
#include <span>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"
#include "clbvh/layout/wide.hpp"
#include "layout/opening.hpp"

namespace clbvh::layout {

/// A binary tree where it lies.
struct TreeView {
    std::span<const Node> nodes;
    std::span<const std::uint32_t> primitive_ids;
    std::uint64_t primitive_count = 0;
    bool split_references = false;
};

[[nodiscard]] inline TreeView view_of(const Bvh& bvh) noexcept {
    return {bvh.nodes, bvh.primitive_ids, bvh.primitive_count, bvh.split_references};
}

/// Joins up to four triangles to a leaf, as many as a block holds.
template <std::uint32_t Width>
using WideRules = OpeningRules<Width, kBlockTriangles, kBlockTriangles * WideChild::kMaxBlocks, kBlockTriangles>;

/// Makes layouts one after the other, and keeps the memory that this takes.
template <std::uint32_t Width>
class WideConverter {
public:
    /// In the current arena. The tree is one over the mesh. Throws Error(unsupported) for too many blocks, and
    /// Error(out_of_memory) or std::bad_alloc; `result` is then empty.
    void run(const TreeView& tree, const MeshView& mesh, WideLayout<Width>& result,
             NodeOpening opening = NodeOpening::largest_first);

private:
    void convert(const TreeView& tree, const MeshView& mesh, WideLayout<Width>& result, NodeOpening opening);

    Opening<WideRules<Width>> opening_;
};

}  // namespace clbvh::layout
