#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "clbvh/layout/triangle_block.hpp"
#include "core/simd/prefetch.hpp"
#include "layout/opening.hpp"

namespace clbvh::layout {

/// Blocks between the steps of what is read for one: its triangles' indices are asked for when their numbers are read,
/// the vertices when the indices are.
inline constexpr std::size_t kBlocksAhead = 12;

/// Puts the vertices of triangles into blocks. primitives_of(i) gives the primitives of block i, kNone where there are
/// fewer than four, and is called once for each block, in order. `triangles` is one of primitive_access.hpp.
template <typename Triangles, typename PrimitivesOf>
void write_vertices(std::size_t count, const Triangles& triangles, TriangleBlock* blocks,
                    const PrimitivesOf& primitives_of) {
    const auto read_primitives = [&](std::size_t i) {
        blocks[i].primitives = primitives_of(i);
        for (const std::uint32_t primitive : blocks[i].primitives) {
            if (primitive != kNone) prefetch(triangles.indices_of(primitive));
        }
    };
    const auto read_indices = [&](const TriangleBlock& block) {
        for (const std::uint32_t primitive : block.primitives) {
            if (primitive == kNone) continue;
            for (std::size_t corner = 0; corner < 3; ++corner)
                prefetch(triangles.vertex(triangles.index(primitive, corner)));
        }
    };
    const auto write = [&](TriangleBlock& block) {
        constexpr float nan = std::numeric_limits<float>::quiet_NaN();
        static constexpr std::array<float, 3> absent = {nan, nan, nan};
        for (std::size_t lane = 0; lane < kBlockTriangles; ++lane) {
            const std::uint32_t primitive = block.primitives[lane];
            for (std::size_t corner = 0; corner < 3; ++corner) {
                const float* const vertex =
                    primitive == kNone ? absent.data() : triangles.vertex(triangles.index(primitive, corner));
                for (std::size_t axis = 0; axis < 3; ++axis)
                    block.vertices[corner][axis][lane] = vertex[axis];
            }
        }
    };
    for (std::size_t i = 0; i < count + 2 * kBlocksAhead; ++i) {
        if (i < count) read_primitives(i);
        if (i >= kBlocksAhead && i - kBlocksAhead < count) read_indices(blocks[i - kBlocksAhead]);
        if (i >= 2 * kBlocksAhead) write(blocks[i - 2 * kBlocksAhead]);
    }
}

/// Copies the triangles at `places` of `primitive_ids` to `blocks`.
template <typename Triangles>
void write_blocks(std::span<const Places> places, const std::uint32_t* primitive_ids, const Triangles& triangles,
                  TriangleBlock* blocks) {
    write_vertices(places.size(), triangles, blocks, [&](std::size_t i) {
        Places primitives = places[i];
        for (std::uint32_t& place : primitives)
            place = place == kNone ? kNone : primitive_ids[place];
        return primitives;
    });
}

}  // namespace clbvh::layout
