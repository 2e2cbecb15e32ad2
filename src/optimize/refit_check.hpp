#pragma once

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"

namespace clbvh::optimizer {

/// Throws Error(invalid_input) unless the active primitives are those of the tree, and what check_primitives throws.
void check_same_primitives(const Bvh& tree, const Primitives& primitives);

}  // namespace clbvh::optimizer
