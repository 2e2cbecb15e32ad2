#pragma once

#include <vector>

#include "clbvh/core/bvh.hpp"

namespace clbvh::device {

/// Whether the nodes 2 * p and 2 * p + 1 belong to the tree, for each p; the root's pair does. Throws
/// Error(invalid_input) where the nodes form no tree, naming the first offender; boxes and leaves are taken as they
/// are.
[[nodiscard]] std::vector<bool> pairs_in_use(const Bvh& tree);

}  // namespace clbvh::device
