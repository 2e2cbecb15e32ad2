#pragma once

#include <clbvh/core/aabb.hpp>

namespace clbvh::tool {

/// The colour, 0 to 1 in sRGB, of a value of 0 (dark blue) to 1 (yellow); equal steps look equal, in grey as well. It
/// is viridis, by Smith and van der Walt (2015, CC0), from ten of its colours.
[[nodiscard]] Vec3 heat_colour(float value);

}  // namespace clbvh::tool
