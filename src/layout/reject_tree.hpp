#pragma once

#include "clbvh/core/bvh.hpp"

namespace clbvh::layout {

/// Throws Error(invalid_input) that names the first node, in traversal order, for which `bvh` is no tree: a converter
/// has met one, but cannot tell which of them is the first.
[[noreturn]] void reject_tree(const Bvh& bvh);

}  // namespace clbvh::layout
