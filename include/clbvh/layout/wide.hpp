#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"
#include "clbvh/export.h"
#include "clbvh/layout/layout_array.hpp"
#include "clbvh/layout/make_layout.hpp"
#include "clbvh/layout/triangle_block.hpp"

namespace clbvh {

/// A child of a WideNode, in 32 bits.
///
/// | child | bit 31 | bits 28 .. 30 | bits 0 .. 27 |
/// |---|---|---|---|
/// | a node | 0 | its number, from bit 30 on | |
/// | a leaf | 1 | its blocks, less one | number of its first block |
/// | none | 1 | 7 | all ones: kNone |
struct WideChild {
    static constexpr std::uint32_t kLeafFlag = 1U << 31U;
    static constexpr std::uint32_t kBlockCountShift = 28;
    static constexpr std::uint32_t kMaxBlocks = 8;  ///< Of one leaf.
    static constexpr std::uint32_t kFirstBlockMask = (1U << kBlockCountShift) - 1;
    static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

    [[nodiscard]] static constexpr std::uint32_t leaf(std::uint32_t first_block, std::uint32_t blocks) noexcept {
        return kLeafFlag | (blocks - 1) << kBlockCountShift | first_block;
    }
    [[nodiscard]] static constexpr bool is_leaf(std::uint32_t child) noexcept { return (child & kLeafFlag) != 0; }
    [[nodiscard]] static constexpr std::uint32_t first_block(std::uint32_t leaf) noexcept {
        return leaf & kFirstBlockMask;
    }
    [[nodiscard]] static constexpr std::uint32_t block_count(std::uint32_t leaf) noexcept {
        return (leaf >> kBlockCountShift & (kMaxBlocks - 1)) + 1;
    }
};

/// The boxes of up to `Width` children, side by side for vectors, and the children. Where there are fewer, the rest
/// stand last: with boxes from infinity to minus infinity, which no ray meets, and kNone.
///
/// | bytes, of 8 | bytes, of 4 | what |
/// |---|---|---|
/// | 0 .. 191 | 0 .. 95 | float32 [lower, upper][axis x y z][child] |
/// | 192 .. 223 | 96 .. 111 | uint32 [child], see WideChild |
template <std::uint32_t Width>
struct alignas(4 * Width) WideNode {
    std::array<std::array<std::array<float, Width>, 3>, 2> bounds;
    std::array<std::uint32_t, Width> children;
};
static_assert(sizeof(WideNode<8>) == 224 && sizeof(WideNode<4>) == 112);

/// A tree over triangles with up to `Width` children a node, and all that a ray needs: neither the binary tree nor the
/// mesh has to stay. The root is node 0, and the children of a node that are nodes are numbered one after the other.
/// Boxes are those of the binary tree's nodes. Leaves with few triangles below one node of the binary tree are joined
/// to one, of up to four triangles.
template <std::uint32_t Width>
struct WideLayout {
    LayoutArray<WideNode<Width>> nodes;  ///< Empty for an empty tree.
    LayoutArray<TriangleBlock> blocks;
    std::uint32_t depth = 0;            ///< Nodes on the longest path.
    std::uint64_t primitive_count = 0;  ///< Of the mesh: primitives of blocks are below it.
    bool split_references = false;      ///< As of the tree: see Bvh.

    [[nodiscard]] bool empty() const noexcept { return nodes.empty(); }
    /// Empties it, and keeps its memory.
    void clear() noexcept {
        nodes.clear();
        blocks.clear();
        depth = 0;
        primitive_count = 0;
        split_references = false;
    }
};
using Wide4 = WideLayout<4>;
using Wide8 = WideLayout<8>;

/// Makes the layout of a tree over triangles, with all threads. The same bytes with any number of them.
/// Nodes are opened until there are `Width` children, as `options` say.
/// `result` is made anew in the memory that it has.
/// Throws Error(invalid_input) naming the first offender where the tree is none over the mesh, Error(unsupported) for
/// more than 2^28 - 1 blocks, Error(out_of_memory). `result` is then empty.
CLBVH_API void make_layout(const Bvh& bvh, const MeshView& mesh, Wide8& result, const LayoutOptions& options = {});
CLBVH_API void make_layout(const Bvh& bvh, const MeshView& mesh, Wide4& result, const LayoutOptions& options = {});

/// Gives a layout the vertices of a mesh that has moved, and the boxes that these ask for, in place and with all
/// threads; its structure stays. O(n) time. No ray may be traced through it meanwhile.
///
/// The layout is one that make_layout() made, or that validate() has proven; its structure is not checked here.
/// `mesh` has as many triangles as the one that it was made over. Leaves get the boxes of whole triangles, also
/// where references were split. A triangle with a NaN is left out of the boxes, and never hit. Boxes only get worse
/// from frame to frame: see docs/layouts.md for when to build anew.
/// Throws what check_mesh throws (unless `options` trust the mesh), and Error(invalid_input) for a mesh with another
/// number of triangles; the layout is then as it was.
CLBVH_API void refit(Wide8& layout, const MeshView& mesh, const LayoutOptions& options = {});
CLBVH_API void refit(Wide4& layout, const MeshView& mesh, const LayoutOptions& options = {});

/// Proves that the layout is a tree over the mesh: children and blocks as documented, every active triangle in one leaf
/// (or, with split references, covered by its leaves), inactive ones in none, vertices those of the mesh bit for bit,
/// and every box around all that is below. Throws Error(invalid_input) naming the first offender. Never reads out of
/// range. O(n) time and memory, and for split references that of clbvh::validate.
///
/// A layout that was refitted is proven over the mesh that it was refitted to, as long as the same triangles are
/// active.
CLBVH_API void validate(const Wide8& layout, const MeshView& mesh);
CLBVH_API void validate(const Wide4& layout, const MeshView& mesh);

}  // namespace clbvh
