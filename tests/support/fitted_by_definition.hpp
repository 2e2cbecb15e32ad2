#pragma once

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"

namespace clbvh::test {

/// Every node with the box of all primitives below it: slow, and sure.
[[nodiscard]] Bvh fitted_by_definition(Bvh tree, const Primitives& primitives);

}  // namespace clbvh::test
