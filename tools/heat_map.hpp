#pragma once

#include <cstdint>
#include <vector>

#include "picture.hpp"

namespace clbvh::tool {

/// The values, one for each pixel, as colours: 0 is dark, `scale_end` and what is above it bright. A bar along the
/// lower edge tells the numbers. A `scale_end` of 0 stands for what 99 % of the values do not exceed.
[[nodiscard]] Picture heat_map(const std::vector<float>& values, std::uint32_t width, std::uint32_t height,
                               float scale_end);

}  // namespace clbvh::tool
