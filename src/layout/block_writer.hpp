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

/// Copies the triangles at `places` of `primitive_ids` to `blocks`. `triangles` is one of primitive_access.hpp. Puts
/// primitives into `places`.
template <typename Triangles>
void write_blocks(std::span<Places> places, const std::uint32_t* primitive_ids, const Triangles& triangles,
                  TriangleBlock* blocks) {
    const auto read_primitives = [&](Places& block) {
        for (std::uint32_t& place : block) {
            if (place == kNone) continue;
            place = primitive_ids[place];
            prefetch(triangles.indices_of(place));
        }
    };
    const auto read_indices = [&](const Places& block) {
        for (const std::uint32_t primitive : block) {
            if (primitive == kNone) continue;
            for (std::size_t corner = 0; corner < 3; ++corner)
                prefetch(triangles.vertex(triangles.index(primitive, corner)));
        }
    };
    const auto write = [&](const Places& primitives, TriangleBlock& block) {
        alignas(16) static constexpr std::array<float, 3> absent = {std::numeric_limits<float>::quiet_NaN(),
                                                                    std::numeric_limits<float>::quiet_NaN(),
                                                                    std::numeric_limits<float>::quiet_NaN()};
        for (std::size_t lane = 0; lane < kBlockTriangles; ++lane) {
            const std::uint32_t primitive = primitives[lane];
            for (std::size_t corner = 0; corner < 3; ++corner) {
                const float* const vertex =
                    primitive == kNone ? absent.data() : triangles.vertex(triangles.index(primitive, corner));
                for (std::size_t axis = 0; axis < 3; ++axis)
                    block.vertices[corner][axis][lane] = vertex[axis];
            }
        }
        block.primitives = primitives;
    };
    const std::size_t count = places.size();
    for (std::size_t i = 0; i < count + 2 * kBlocksAhead; ++i) {
        if (i < count) read_primitives(places[i]);
        if (i >= kBlocksAhead && i - kBlocksAhead < count) read_indices(places[i - kBlocksAhead]);
        if (i >= 2 * kBlocksAhead) write(places[i - 2 * kBlocksAhead], blocks[i - 2 * kBlocksAhead]);
    }
}

}  // namespace clbvh::layout
