#pragma once

#include "clbvh/core/bvh.hpp"
#include "clbvh/metrics/sah.hpp"

namespace clbvh {

/// C_n of Aila, Karras, Laine 2013: what visiting a node costs.
[[nodiscard]] constexpr double node_cost(const Node& node, const SahCosts& costs) noexcept {
    return node.is_leaf() ? costs.primitive * node.count : costs.inner;
}

}  // namespace clbvh
