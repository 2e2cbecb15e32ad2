#pragma once

#include <string>

#include "clbvh/core/bvh.hpp"

namespace clbvh::test {

/// Walks both trees from their roots and compares them node for node, up to numbering: boxes, which child is left, and
/// the primitives of each leaf in their order. Returns the path of the first difference and what differs there, or
/// nothing where the trees are equal. Reads nothing out of range, whatever the trees hold.
[[nodiscard]] std::string compare_trees(const Bvh& a, const Bvh& b);

/// True where both trees have the same children and leaves in the same numbering, whatever their boxes.
[[nodiscard]] bool same_topology(const Bvh& a, const Bvh& b);

}  // namespace clbvh::test
