#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "clbvh/layout/wide.hpp"
#include "core/primitive_access.hpp"
#include "core/simd/float4.hpp"
#include "layout/block_writer.hpp"
#include "layout/refit_in_arena.hpp"

namespace clbvh::layout {
namespace {

/// A box while it grows, in vectors whose lanes are merged at the end: lower corners, and upper ones with their sign
/// turned. What is NaN changes nothing.
class GrowingBox {
public:
    void add(std::size_t axis, Float4 lower, Float4 upper) noexcept {
        lower_[axis] = min(lower, lower_[axis]);
        negated_upper_[axis] = min(upper.negated(), negated_upper_[axis]);
    }

    template <std::uint32_t Width>
    void store(WideNode<Width>& node, std::uint32_t slot) const noexcept {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            node.bounds[0][axis][slot] = lower_[axis].least();
            node.bounds[1][axis][slot] = -negated_upper_[axis].least();
        }
    }

private:
    static Float4 empty() noexcept { return Float4::filled(kPositiveInfinity); }

    std::array<Float4, 3> lower_ = {empty(), empty(), empty()};
    std::array<Float4, 3> negated_upper_ = lower_;
};

void add_block(GrowingBox& box, const TriangleBlock& block) noexcept {
    for (const auto& vertex : block.vertices) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const Float4 row = Float4::load(vertex[axis].data());
            box.add(axis, row, row);
        }
    }
}

template <std::uint32_t Width>
void add_children(GrowingBox& box, const WideNode<Width>& node) noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::uint32_t begin = 0; begin < Width; begin += 4) {
            box.add(axis, Float4::load(node.bounds[0][axis].data() + begin),
                    Float4::load(node.bounds[1][axis].data() + begin));
        }
    }
}

template <std::uint32_t Width>
void refit_leaves(WideNode<Width>& node, const TriangleBlock* blocks) noexcept {
    for (std::uint32_t slot = 0; slot < Width; ++slot) {
        const std::uint32_t child = node.children[slot];
        if (child == WideChild::kNone || !WideChild::is_leaf(child)) continue;
        GrowingBox box;
        for (std::uint32_t i = 0; i < WideChild::block_count(child); ++i)
            add_block(box, blocks[WideChild::first_block(child) + i]);
        box.store(node, slot);
    }
}

/// Backwards, since every node has a higher number than its parent. A small part of the work: there are ten times as
/// many triangles as nodes.
template <std::uint32_t Width>
void refit_inner_children(LayoutArray<WideNode<Width>>& nodes) noexcept {
    for (std::size_t i = nodes.size(); i-- > 0;) {
        WideNode<Width>& node = nodes[i];
        for (std::uint32_t slot = 0; slot < Width; ++slot) {
            const std::uint32_t child = node.children[slot];
            if (WideChild::is_leaf(child)) continue;
            GrowingBox box;
            add_children(box, nodes[child]);
            box.store(node, slot);
        }
    }
}

template <std::uint32_t Width>
void run_refit(WideLayout<Width>& layout, const MeshView& mesh) {
    constexpr std::size_t kBlocksOfTask = 1024, kNodesOfTask = 256;
    with_triangles(mesh, [&](const auto& triangles) {
        tbb::parallel_for(
            tbb::blocked_range<std::size_t>(0, layout.blocks.size(), kBlocksOfTask), [&](const auto& range) {
                TriangleBlock* const first = layout.blocks.data() + range.begin();
                write_vertices(range.size(), triangles, first, [&](std::size_t i) { return first[i].primitives; });
            });
    });
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, layout.nodes.size(), kNodesOfTask), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i)
            refit_leaves(layout.nodes[i], layout.blocks.data());
    });
    refit_inner_children(layout.nodes);
}

}  // namespace
}  // namespace clbvh::layout

namespace clbvh {

void refit(Wide8& layout, const MeshView& mesh, const LayoutOptions& options) {
    layout::refit_in_arena(layout, mesh, options, [&] { layout::run_refit(layout, mesh); });
}

void refit(Wide4& layout, const MeshView& mesh, const LayoutOptions& options) {
    layout::refit_in_arena(layout, mesh, options, [&] { layout::run_refit(layout, mesh); });
}

}  // namespace clbvh
