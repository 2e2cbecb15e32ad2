#pragma once

namespace clbvh::host {

/// The weight of one primitive in SAH costs within a box of this half area: a power of two, and 1 unless the
/// coordinates are so large that sums over many primitives would overflow.
[[nodiscard]] constexpr float cost_unit(float half_area) noexcept {
    return half_area < 0x1p90f ? 1.0f : 0x1p-30f;
}

}  // namespace clbvh::host
