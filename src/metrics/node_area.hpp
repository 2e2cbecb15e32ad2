#pragma once

#include "clbvh/core/bvh.hpp"

namespace clbvh {

/// Half the surface area in double precision; only ratios of areas matter.
[[nodiscard]] constexpr double node_area(const Node& node) noexcept {
    const double x = double{node.upper[0]} - double{node.lower[0]};
    const double y = double{node.upper[1]} - double{node.lower[1]};
    const double z = double{node.upper[2]} - double{node.lower[2]};
    return x * y + y * z + z * x;
}

}  // namespace clbvh
