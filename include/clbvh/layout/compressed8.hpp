#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"
#include "clbvh/export.h"
#include "clbvh/layout/layout_array.hpp"
#include "clbvh/layout/make_layout.hpp"

namespace clbvh {

/// One node of a Compressed8; 80 bytes, little-endian. Its up to eight children are in slots, whose boxes are a grid's:
/// origin + q * 2^exponent on each axis, with q from 0 to 255.
///
/// | bytes | what |
/// |---|---|
/// | 0 .. 11 | float32 x y z of the grid's origin |
/// | 12 .. 14 | int8 x y z, the exponent of the grid's step, -126 to 127 |
/// | 15 | uint8 inner mask: bit s is 1 where the child in slot s is a node |
/// | 16 .. 19 | uint32 number of the first child that is a node; the others follow it, in the order of their slots |
/// | 20 .. 23 | uint32 place of the node's first triangle in the triangles, in units of 16 bytes: 3 * its number |
/// | 24 .. 31 | uint8 meta of slots 0 .. 7: see below |
/// | 32 .. 55 | uint8 q of lower x, slots 0 .. 7, then of lower y, of lower z |
/// | 56 .. 79 | uint8 q of upper x, slots 0 .. 7, then of upper y, of upper z |
///
/// | meta | bits 5 .. 7 | bits 0 .. 4 |
/// |---|---|---|
/// | a node in slot s | 1 | 24 + s |
/// | a leaf | 1, 3 or 7: as many ones as triangles | number of its first triangle, from the node's first: 0 to 21 |
/// | nothing | 0 | 0 |
struct Compressed8Node {
    std::array<float, 3> origin;
    std::array<std::int8_t, 3> exponent;
    std::uint8_t inner_mask;
    std::uint32_t first_child;
    std::uint32_t first_triangle;
    std::array<std::uint8_t, 8> meta;
    std::array<std::array<std::uint8_t, 8>, 3> lower;
    std::array<std::array<std::uint8_t, 8>, 3> upper;

    [[nodiscard]] constexpr bool is_empty(std::uint32_t slot) const noexcept { return meta[slot] == 0; }
    [[nodiscard]] constexpr bool is_inner(std::uint32_t slot) const noexcept { return (inner_mask >> slot & 1U) != 0; }
    /// Number of the node in `slot`, where there is one.
    [[nodiscard]] constexpr std::uint32_t child(std::uint32_t slot) const noexcept {
        return first_child + static_cast<std::uint32_t>(std::popcount(inner_mask & ((1U << slot) - 1)));
    }
    /// Triangles of the leaf in `slot`, where there is one, and the number of the first.
    [[nodiscard]] constexpr std::uint32_t triangle_count(std::uint32_t slot) const noexcept {
        return static_cast<std::uint32_t>(std::popcount(static_cast<std::uint32_t>(meta[slot]) >> 5U));
    }
    [[nodiscard]] constexpr std::uint32_t triangle(std::uint32_t slot) const noexcept {
        return first_triangle / 3 + (meta[slot] & 31U);
    }
    /// The box of the child in `slot`, rounded to floats: around all that is below, as the exact one is.
    [[nodiscard]] constexpr Aabb bounds(std::uint32_t slot) const noexcept {
        const auto corner = [&](const std::array<std::array<std::uint8_t, 8>, 3>& q, std::size_t axis) {
            const auto step = std::bit_cast<float>(static_cast<std::uint32_t>(exponent[axis] + 127) << 23U);
            return origin[axis] + static_cast<float>(q[axis][slot]) * step;
        };
        return {{corner(lower, 0), corner(lower, 1), corner(lower, 2)},
                {corner(upper, 0), corner(upper, 1), corner(upper, 2)}};
    }
};
static_assert(sizeof(Compressed8Node) == 80 && offsetof(Compressed8Node, inner_mask) == 15);
static_assert(offsetof(Compressed8Node, meta) == 24 && offsetof(Compressed8Node, upper) == 56);

/// One triangle of a Compressed8; 48 bytes, little-endian: what the test of Moeller and Trumbore reads.
///
/// | bytes | what |
/// |---|---|
/// | 0 .. 11 | float32 x y z of vertex 2 - vertex 0 |
/// | 12 .. 15 | 0 |
/// | 16 .. 27 | float32 x y z of vertex 1 - vertex 0 |
/// | 28 .. 31 | 0 |
/// | 32 .. 43 | float32 x y z of vertex 0 |
/// | 44 .. 47 | uint32 primitive |
struct Compressed8Triangle {
    std::array<float, 3> edge2;
    std::uint32_t zero0;
    std::array<float, 3> edge1;
    std::uint32_t zero1;
    std::array<float, 3> vertex0;
    std::uint32_t primitive;
};
static_assert(sizeof(Compressed8Triangle) == 48 && offsetof(Compressed8Triangle, primitive) == 44);

/// A tree over triangles with up to eight children a node, whose boxes take a byte a plane: Ylitie, Karras, Laine 2017,
/// "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs". Byte for byte the nodes and triangles of
/// tinybvh's BVH8_CWBVH. The root is node 0, also where all triangles are in one leaf.
///
/// Children are in slots by where they are in their node, so that a ray goes to them roughly from near to far: a child
/// on the lower side of an axis is in a slot without that axis' bit (4: x, 2: y, 1: z), and a ray that ascends along
/// all axes visits slots from 0 to 7, another the slots XOR the bits of the axes along which it descends.
/// Leaves have up to three triangles: small ones below one node of the binary tree are joined, larger ones divided.
struct Compressed8 {
    LayoutArray<Compressed8Node> nodes;  ///< Empty for an empty tree.
    LayoutArray<Compressed8Triangle> triangles;
    std::uint32_t depth = 0;            ///< Nodes on the longest path; a stack of node groups holds no more than that.
    std::uint64_t primitive_count = 0;  ///< Of the mesh: primitives of triangles are below it.
    bool split_references = false;      ///< As of the tree: see Bvh.

    [[nodiscard]] bool empty() const noexcept { return nodes.empty(); }
    /// Empties it, and keeps its memory.
    void clear() noexcept {
        nodes.clear();
        triangles.clear();
        depth = 0;
        primitive_count = 0;
        split_references = false;
    }
};

/// Makes the layout of a tree over triangles, with all threads; the same bytes with any number of them. `result` is
/// made anew in the memory that it has. Throws Error(invalid_input) naming the first offender where the tree is none
/// over the mesh, Error(unsupported) where there are so many triangles that their places do not fit into 32 bits,
/// Error(out_of_memory). `result` is then empty.
CLBVH_API void make_layout(const Bvh& bvh, const MeshView& mesh, Compressed8& result,
                           const LayoutOptions& options = {});

/// Gives a layout the triangles of a mesh that has moved, and the boxes that these ask for, on new grids, in place and
/// with all threads; its structure stays. O(n) time, 32 bytes a node of other memory. No ray may be traced through it
/// meanwhile.
///
/// The layout is one that make_layout() made, or that validate() has proven; its structure is not checked here.
/// Children stay in the slots that were theirs when the layout was made: where they have moved to the other side of
/// each other, rays still find all that is there, but no longer go from near to far. `mesh` has as many triangles as
/// the one that the layout was made over. Leaves get the boxes of whole triangles, also where references were split.
/// What is NaN is left out of the boxes, and a triangle with a NaN is never hit. Boxes only get worse from frame to
/// frame: see docs/layouts.md for when to build anew. Throws what check_mesh throws (unless `options` trust the mesh),
/// Error(invalid_input) for a mesh with another number of triangles, and Error(out_of_memory); the layout is as it was
/// after the first two.
CLBVH_API void refit(Compressed8& layout, const MeshView& mesh, const LayoutOptions& options = {});

/// Proves that the layout is a tree over the mesh: every byte as documented, every active triangle in one leaf (or,
/// with split references, covered by its leaves), inactive ones in none, and every exact box around all that is below.
/// Throws Error(invalid_input) naming the first offender. Never reads out of range. O(n) time and memory, and for split
/// references that of clbvh::validate.
CLBVH_API void validate(const Compressed8& layout, const MeshView& mesh);

}  // namespace clbvh
