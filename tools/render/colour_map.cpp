#include "render/colour_map.hpp"

#include <algorithm>
#include <array>
#include <clbvh/core/vector.hpp>
#include <cstddef>
#include <cstdint>

namespace clbvh::tool {
namespace {

constexpr std::array<std::uint32_t, 10> kColours{0x440154, 0x482878, 0x3e4989, 0x31688e, 0x26828e,
                                                 0x1f9e89, 0x35b779, 0x6ece58, 0xb5de2b, 0xfde725};

Vec3 colour(std::uint32_t hexadecimal) {
    const auto channel = [&](unsigned shift) { return static_cast<float>(hexadecimal >> shift & 0xFFU) / 255.0f; };
    return {channel(16), channel(8), channel(0)};
}

}  // namespace

Vec3 heat_colour(float value) {
    const float at = std::clamp(value, 0.0f, 1.0f) * static_cast<float>(kColours.size() - 1);
    const std::size_t below = std::min(static_cast<std::size_t>(at), kColours.size() - 2);
    const Vec3 from = colour(kColours[below]);
    return from + (colour(kColours[below + 1]) - from) * (at - static_cast<float>(below));
}

}  // namespace clbvh::tool
