#pragma once

#include <string>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"

namespace clbvh::test {

/// A tree over a mesh.
struct MeshTree {
    std::string name;
    Mesh mesh;
    Bvh bvh;
};

/// Trees of every host builder over the mesh, with leaves of one and of several triangles, and with split triangles.
[[nodiscard]] std::vector<MeshTree> trees_of_host_builders(const Mesh& mesh, const std::string& name);

/// Trees that no builder makes or that are rare: none, of one leaf, of one large leaf, a chain, with slots that no node
/// uses, with inactive triangles, of many triangles in one place.
[[nodiscard]] std::vector<MeshTree> odd_trees();

/// A tree of one leaf over all triangles.
[[nodiscard]] Bvh one_leaf(const Mesh& mesh);

/// A tree over three triangles, whose root's children are a node with two leaves and a leaf; its ids are 2, 1, 0.
[[nodiscard]] MeshTree tree_of_three();

}  // namespace clbvh::test
