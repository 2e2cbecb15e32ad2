#include "layout/check_tree.hpp"

#include <algorithm>
#include <string>

#include "clbvh/core/error.hpp"
#include "core/tree_walk.hpp"
#include "core/view_form.hpp"

namespace clbvh::layout {
namespace {

[[noreturn]] void reject(const std::string& fault) {
    throw Error(ErrorCode::invalid_input,
                "the tree cannot be traced: " + fault + "; give a tree that was built over this mesh");
}

/// Leaves can then refer to any range of them.
void check_primitives(const Bvh& bvh, const MeshView& mesh) {
    if (bvh.primitive_count != mesh.triangle_count) {
        reject("it is over " + std::to_string(bvh.primitive_count) + " primitives, the mesh has " +
               std::to_string(mesh.triangle_count) + " triangles");
    }
    for (const std::uint32_t primitive : bvh.primitive_ids) {
        if (primitive >= mesh.triangle_count) {
            reject("primitive " + std::to_string(primitive) + " is out of range, the mesh has " +
                   std::to_string(mesh.triangle_count) + " triangles");
        }
        for (const std::uint32_t vertex : mesh.triangle(primitive)) {
            if (vertex < mesh.vertex_count) continue;
            reject("triangle " + std::to_string(primitive) + " has vertex " + std::to_string(vertex) +
                   ", the mesh has " + std::to_string(mesh.vertex_count) + " vertices");
        }
    }
}

}  // namespace

std::uint32_t check_tree(const Bvh& bvh, const MeshView& mesh) {
    check_form(mesh);
    check_primitives(bvh, mesh);
    TreeWalk walk(bvh);
    std::uint32_t depth = 0;
    std::uint64_t references = 0;
    while (walk.next()) {
        depth = std::max(depth, walk.depth());
        references += bvh.nodes[walk.node()].count;
        if (references > bvh.primitive_ids.size())
            reject("leaves share primitive ids, the last at " + name_node(walk.node()));
    }
    if (walk.failed()) reject(walk.fault());
    return depth;
}

}  // namespace clbvh::layout
