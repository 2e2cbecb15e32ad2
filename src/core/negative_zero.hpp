#pragma once

#include "clbvh/core/aabb.hpp"
#include "core/simd/box4.hpp"

// Adding +0 turns -0 into +0, and changes nothing else. Unions of boxes are then the same bits in any order.
namespace clbvh {

[[nodiscard]] constexpr Vec3 without_negative_zeros(const Vec3& v) noexcept {
    return {v.x + 0.0f, v.y + 0.0f, v.z + 0.0f};
}

[[nodiscard]] inline Box4 without_negative_zeros(const Box4& box) noexcept {
    return {box.lower + Float4::filled(0.0f), box.upper + Float4::filled(0.0f)};
}

}  // namespace clbvh
