#pragma once

#include <array>

#include "core/simd/box4.hpp"

namespace clbvh {

/// The half areas of four boxes at once, each as Box4::half_area() gives it, to the bit.
[[nodiscard]] inline std::array<float, 4> half_areas(const std::array<Box4, 4>& boxes) noexcept {
    Float4 x = boxes[0].upper - boxes[0].lower;
    Float4 y = boxes[1].upper - boxes[1].lower;
    Float4 z = boxes[2].upper - boxes[2].lower;
    Float4 w = boxes[3].upper - boxes[3].lower;
    Float4::transpose(x, y, z, w);
    std::array<float, 4> areas;
    (x * (y + z) + y * z).store(areas.data());
    return areas;
}

}  // namespace clbvh
