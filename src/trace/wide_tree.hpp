#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "kernels/trace/trace_constants.h"
#include "trace/huge_page_array.hpp"
#include "trace/leaf_triangles.hpp"

namespace clbvh::trace {

inline constexpr std::uint32_t kWideChildren = 8;
inline constexpr std::uint32_t kBlockTriangles = kernels::BLOCK_TRIANGLES;

/// Eight boxes, side by side for vectors. A child is the index of a wide node, or that of a leaf's first block with
/// kLeafFlag; where there are fewer than eight, the rest have boxes that no ray meets.
struct alignas(32) WideNode {
    std::array<std::array<std::array<float, kWideChildren>, 3>, 2> bounds;  ///< [lower or upper][axis][child]
    std::array<std::uint32_t, kWideChildren> children;
};
static_assert(sizeof(WideNode) == sizeof(float) * kernels::WIDE_NODE_FLOATS);
static_assert(offsetof(WideNode, children) == sizeof(float) * kernels::WIDE_CHILDREN);

inline constexpr std::uint32_t kLeafFlag = 1U << kernels::WIDE_LEAF_BIT;

/// Four triangles of a leaf, side by side. Where there are fewer, the rest have vertices of NaN, which no ray hits.
struct alignas(16) TriangleBlock {
    std::array<std::array<std::array<float, kBlockTriangles>, 3>, 3> vertices;  ///< [vertex][axis][triangle]
    /// The first has kLastBlockFlag where the leaf has no further block; primitives are below 2^30.
    std::array<std::uint32_t, kBlockTriangles> primitives;

    [[nodiscard]] bool is_last() const noexcept { return (primitives[0] & kLastBlockFlag) != 0; }
    [[nodiscard]] std::uint32_t primitive(std::uint32_t lane) const noexcept {
        return primitives[lane] & ~kLastBlockFlag;
    }
    [[nodiscard]] TriangleVertices triangle(std::uint32_t lane) const noexcept {
        const auto vertex = [&](std::size_t i) {
            return Vec3{vertices[i][0][lane], vertices[i][1][lane], vertices[i][2][lane]};
        };
        return {vertex(0), vertex(1), vertex(2)};
    }

    static constexpr std::uint32_t kLastBlockFlag = 1U << kernels::LAST_BLOCK_BIT;
};
static_assert(sizeof(TriangleBlock) == sizeof(float) * kernels::BLOCK_FLOATS);

/// A tree of two children laid out for speed: its nodes with up to eight children, its leaves with up to four triangles
/// where that joins smaller ones. Boxes are those of the binary tree's nodes, so a ray meets all triangles that it may
/// hit through that tree.
struct WideTree {
    HugePageArray<WideNode> nodes;  ///< The root is the first; empty for an empty tree.
    HugePageArray<TriangleBlock> blocks;
    std::uint32_t depth = 0;  ///< Nodes on the longest path.
};

/// `bvh` has passed check_tree; `triangles` are its triangles in the order of its primitive ids.
[[nodiscard]] WideTree make_wide_tree(std::span<const Node> nodes, std::span<const LeafTriangle> triangles);

}  // namespace clbvh::trace
