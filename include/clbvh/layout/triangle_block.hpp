#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "clbvh/core/ray.hpp"

namespace clbvh {

inline constexpr std::uint32_t kBlockTriangles = 4;

/// Four triangles of a leaf, side by side for vectors; 160 bytes. Where there are fewer, the rest have vertices of NaN,
/// which no ray hits, and kNoPrimitive.
///
/// | bytes | what |
/// |---|---|
/// | 0 .. 143 | float32 [vertex 0 .. 2][axis x y z][triangle 0 .. 3] |
/// | 144 .. 159 | uint32 [triangle 0 .. 3], the primitives |
struct alignas(16) TriangleBlock {
    std::array<std::array<std::array<float, kBlockTriangles>, 3>, 3> vertices;
    std::array<std::uint32_t, kBlockTriangles> primitives;
};
static_assert(sizeof(TriangleBlock) == 160 && offsetof(TriangleBlock, primitives) == 144);

}  // namespace clbvh
