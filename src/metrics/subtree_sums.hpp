#pragma once

#include <cstdint>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "clbvh/metrics/sah.hpp"
#include "metrics/leaf_order.hpp"

namespace clbvh {

/// Sums over all nodes of a subtree, so that a triangle that lies in each of them need not visit them: where very many
/// primitives have the same box, nearly all nodes do.
class SubtreeSums {
public:
    SubtreeSums(const Bvh& bvh, const LeafOrder& order, const SahCosts& costs);

    /// Intersection of the boxes of all nodes of `node`'s subtree; empty, lower above upper, where there is no such
    /// place.
    [[nodiscard]] const Aabb& core(std::uint32_t node) const noexcept { return sums_[node].core; }
    /// Cost of visiting all nodes of the subtree.
    [[nodiscard]] double cost(std::uint32_t node) const noexcept { return sums_[node].cost; }

private:
    struct Sum {
        Aabb core;
        double cost = 0.0;
    };

    std::vector<Sum> sums_;
};

}  // namespace clbvh
