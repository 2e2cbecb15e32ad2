#include "support/layout_trees.hpp"

#include <numeric>

#include "clbvh/builder.hpp"
#include "clbvh/io/scene.hpp"
#include "support/hard_trees.hpp"
#include "support/meshes.hpp"

namespace clbvh::test {

std::vector<MeshTree> trees_of_host_builders(const Mesh& mesh, const std::string& name) {
    std::vector<MeshTree> trees;
    for (const BuilderInfo& info : builders()) {
        if (info.kind != BuilderKind::host) continue;
        for (const auto& [presplit, max_leaf] :
             {std::pair{0u, 0u}, std::pair{0u, 8u}, std::pair{14u, 0u}, std::pair{14u, 4u}}) {
            BuildOptions options;
            options.presplit_level = presplit;
            options.max_leaf_size = max_leaf;
            trees.push_back({name + ", " + std::string(info.id) + (presplit > 0 ? " presplit" : "") + " leaves of " +
                                 std::to_string(max_leaf),
                             mesh, build(mesh, info.id, options)});
        }
    }
    return trees;
}

Bvh one_leaf(const Mesh& mesh) {
    Bvh tree;
    tree.primitive_count = mesh.triangles.size();
    tree.primitive_ids.resize(mesh.triangles.size());
    std::iota(tree.primitive_ids.begin(), tree.primitive_ids.end(), 0U);
    Aabb box;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        box = merge(box, triangle_bounds(mesh, i));
    tree.nodes.resize(2);
    tree.nodes[0] = {{box.lower.x, box.lower.y, box.lower.z},
                     0,
                     {box.upper.x, box.upper.y, box.upper.z},
                     static_cast<std::uint32_t>(mesh.triangles.size())};
    return tree;
}

std::vector<MeshTree> odd_trees() {
    std::vector<MeshTree> trees;
    trees.push_back({"no triangle", {}, {}});
    for (const std::uint32_t count : {1u, 2u, 3u, 4u, 9u, 10u, 100u, 1000u}) {
        const Mesh mesh = random_triangles(count);
        const std::string triangles = std::to_string(count) + " triangles";
        trees.push_back({"one leaf of " + triangles, mesh, one_leaf(mesh)});
        trees.push_back({"a chain of " + triangles, mesh, chain_tree(mesh)});
        trees.push_back({"strays between " + triangles, mesh, with_strays(build(mesh, "sweep-sah"))});
    }
    Mesh some_inactive = random_triangles(500);
    deactivate_triangles(some_inactive, 3, 7);
    trees.push_back({"inactive triangles", some_inactive, build(some_inactive, "binned-sah")});
    Mesh all_inactive = random_triangles(5);
    deactivate_triangles(all_inactive);
    trees.push_back({"no active triangle", all_inactive, build(all_inactive, "binned-sah")});
    const Mesh coincident = coincident_triangles(100);
    trees.push_back({"one place", coincident, build(coincident, "binned-sah")});
    const Mesh line = line_of_points(500);
    trees.push_back({"a line", line, build(line, "aac-fast")});
    return trees;
}

MeshTree tree_of_three() {
    const Mesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {4, 0, 0}, {5, 0, 0}, {4, 1, 0}, {9, 0, 0}, {9, 2, 0}, {9, 0, 2}},
                    {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}}};
    Bvh tree;
    tree.primitive_count = 3;
    tree.primitive_ids = {2, 1, 0};
    tree.nodes = {{{0, 0, 0}, 4, {9, 2, 2}, 0}, {},                            // root
                  {{0, 0, 0}, 2, {1, 1, 0}, 1}, {{4, 0, 0}, 1, {5, 1, 0}, 1},  // children of node 4
                  {{0, 0, 0}, 2, {5, 1, 0}, 0}, {{9, 0, 0}, 0, {9, 2, 2}, 1}};
    return {"three triangles", mesh, tree};
}

}  // namespace clbvh::test
