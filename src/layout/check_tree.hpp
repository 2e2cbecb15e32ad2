#pragma once

#include <cstdint>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"

namespace clbvh::layout {

/// Proves that all references of `bvh` are in range for `mesh`, and that its nodes form a tree, in linear time and
/// in parallel, in the calling task arena; boxes are taken as they are. Returns its depth. Throws Error(invalid_input)
/// naming the first offender.
std::uint32_t check_tree(const Bvh& bvh, const MeshView& mesh);

}  // namespace clbvh::layout
