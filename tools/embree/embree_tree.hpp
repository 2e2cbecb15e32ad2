#pragma once

#include <embree3/rtcore.h>

#include <array>
#include <clbvh/core/aabb.hpp>
#include <clbvh/core/bvh.hpp>

namespace clbvh::tool {

/// A child of EmbreeNode: an EmbreeNode's address, or with bit 0 set a leaf's, or with bit 1 set as well no address but
/// the one primitive of a leaf, from bit 2 on.
using EmbreeChild = void*;

/// An inner node as the callbacks of rtcBuildBVH fill it: one cache line.
struct EmbreeNode {
    std::array<Aabb, 2> bounds;
    std::array<EmbreeChild, 2> children;
};
static_assert(sizeof(EmbreeNode) == 64);

/// Sets the callbacks of `arguments` that make such a tree; rtcBuildBVH then returns an EmbreeChild.
void set_tree_callbacks(RTCBuildArguments& arguments);

/// Reads a tree back; `root_bounds` matter where the root is a leaf. Duplicates within a leaf are dropped, and the ids
/// of a leaf ascend. nodes and primitive_ids of the result are filled.
[[nodiscard]] Bvh read_tree(EmbreeChild root, const Aabb& root_bounds);

}  // namespace clbvh::tool
