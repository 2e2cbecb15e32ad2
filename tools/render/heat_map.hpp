#pragma once

#include <cstdint>
#include <vector>

#include "render/picture.hpp"

namespace clbvh::tool {

/// The value that 99 % of all do not exceed, rounded up to a whole number, and at least 1: a scale's end that a few hot
/// pixels do not spoil.
[[nodiscard]] float fitting_scale_end(std::vector<float> values);

/// The values, one for each pixel, as colours: 0 is dark, `scale_end`, above 0, and what is beyond it bright. A bar
/// along the lower edge shows the scale.
[[nodiscard]] Picture heat_map(const std::vector<float>& values, std::uint32_t width, std::uint32_t height,
                               float scale_end);

}  // namespace clbvh::tool
