#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "clbvh/core/aabb.hpp"
#include "core/simd/float4.hpp"

namespace clbvh::layout {

/// Lanes 4 * part to 4 * part + 3 of eight: infinite in lane `lane`, minus infinite in the others.
[[nodiscard]] CLBVH_ALWAYS_INLINE Float4 lane_of_eight(std::uint32_t lane, std::uint32_t part) noexcept {
    constexpr float most = kPositiveInfinity, least = kNegativeInfinity;
    // Seven lanes before the one and seven behind it, with a part beginning at any of them.
    static constexpr std::array<float, 15> kLanes = {least, least, least, least, least, least, least, most,
                                                     least, least, least, least, least, least, least};
    return Float4::load(kLanes.data() + 7 - lane + std::size_t{4} * part);
}

}  // namespace clbvh::layout
