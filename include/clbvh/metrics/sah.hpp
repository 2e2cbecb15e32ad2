#pragma once

#include "clbvh/core/bvh.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// Costs of the surface area heuristic; the defaults are those of Aila, Karras and Laine 2013.
struct SahCosts {
    double inner = 1.2;      ///< Cost of visiting an inner node, >= 0.
    double primitive = 1.0;  ///< Cost of testing one primitive, >= 0.
};

/// The SAH cost of a tree: the expected cost of a random line through the root's box, in double precision.
///
/// Aila, Karras, Laine 2013, equation 1: sum over inner nodes of C_inner A(n) / A(root), plus sum over leaves of
/// C_primitive |leaf| A(leaf) / A(root). An empty tree costs 0; a root of zero area counts every node as hit.
///
/// One walk over the nodes, a few milliseconds a million of them, in the calling task arena of oneTBB; the same bits on
/// any number of threads. So it is cheap enough to ask after every change whether to build anew.
/// Throws Error(invalid_input) for a negative or non-finite cost, and where children are out of range or the walk would
/// not end, naming the node.
[[nodiscard]] CLBVH_API double sah_cost(const Bvh& bvh, const SahCosts& costs = {});

}  // namespace clbvh
