#pragma once

#include <cstdint>

#include "clbvh/layout/compressed8.hpp"
#include "core/primitive_access.hpp"

namespace clbvh::layout {

/// `Triangles` is one of primitive_access.hpp.
template <typename Triangles>
[[nodiscard]] Compressed8Triangle make_triangle(const Triangles& triangles, std::uint32_t primitive) noexcept {
    const TriangleBoxes access{triangles};
    const Vec3 v0 = access.corner(primitive, 0), v1 = access.corner(primitive, 1), v2 = access.corner(primitive, 2);
    return {{v2.x - v0.x, v2.y - v0.y, v2.z - v0.z},
            0,
            {v1.x - v0.x, v1.y - v0.y, v1.z - v0.z},
            0,
            {v0.x, v0.y, v0.z},
            primitive};
}

}  // namespace clbvh::layout
