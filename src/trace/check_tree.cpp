#include "trace/check_tree.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "clbvh/core/error.hpp"

namespace clbvh::trace {
namespace {

[[noreturn]] void reject(const std::string& fault) {
    throw Error(ErrorCode::invalid_input,
                "the tree cannot be traced: " + fault + "; give a tree that was built over this mesh");
}

std::string name_node(std::size_t node) {
    return "node " + std::to_string(node);
}

/// Leaves can then refer to any range of them.
void check_primitives(const Bvh& bvh, const Mesh& mesh) {
    if (bvh.primitive_count != mesh.triangles.size()) {
        reject("it is over " + std::to_string(bvh.primitive_count) + " primitives, the mesh has " +
               std::to_string(mesh.triangles.size()) + " triangles");
    }
    for (const std::uint32_t primitive : bvh.primitive_ids) {
        if (primitive >= mesh.triangles.size()) {
            reject("primitive " + std::to_string(primitive) + " is out of range, the mesh has " +
                   std::to_string(mesh.triangles.size()) + " triangles");
        }
        for (const std::uint32_t vertex : mesh.triangles[primitive]) {
            if (vertex < mesh.vertices.size()) continue;
            reject("triangle " + std::to_string(primitive) + " has vertex " + std::to_string(vertex) +
                   ", the mesh has " + std::to_string(mesh.vertices.size()) + " vertices");
        }
    }
}

void check_leaf(const Bvh& bvh, std::size_t index) {
    const Node& node = bvh.nodes[index];
    const std::uint64_t end = std::uint64_t{node.first} + node.count;
    if (end <= bvh.primitive_ids.size()) return;
    reject(name_node(index) + " has a primitive range that ends at " + std::to_string(end) + ", there are " +
           std::to_string(bvh.primitive_ids.size()) + " primitive ids");
}

void check_inner(const Bvh& bvh, std::size_t index, std::vector<bool>& pair_reached) {
    const std::uint32_t first = bvh.nodes[index].first;
    const bool is_odd = first % 2 != 0;
    const bool is_in_range = std::size_t{first} + 1 < bvh.nodes.size();
    if (!is_odd && is_in_range && !pair_reached[first / 2]) {
        pair_reached[first / 2] = true;
        return;
    }
    const std::string children = name_node(index) + " has children at " + std::to_string(first) + ", ";
    if (is_odd) reject(children + "which is odd");
    if (!is_in_range) reject(children + "there are " + std::to_string(bvh.nodes.size()) + " nodes");
    reject(children + "which have another parent or are the root");
}

}  // namespace

std::uint32_t check_tree(const Bvh& bvh, const Mesh& mesh) {
    check_primitives(bvh, mesh);
    if (bvh.empty()) return 0;
    struct Visit {
        std::uint32_t node, depth;
    };
    std::vector<Visit> stack{{0, 0}};
    std::vector<bool> pair_reached((bvh.nodes.size() + 1) / 2, false);
    pair_reached[0] = true;
    std::uint32_t depth = 0;
    std::uint64_t references = 0;
    while (!stack.empty()) {
        const Visit visit = stack.back();
        stack.pop_back();
        depth = std::max(depth, visit.depth);
        const Node& node = bvh.nodes[visit.node];
        if (node.is_leaf()) {
            check_leaf(bvh, visit.node);
            references += node.count;
            if (references > bvh.primitive_ids.size())
                reject("leaves share primitive ids, the last at " + name_node(visit.node));
            continue;
        }
        check_inner(bvh, visit.node, pair_reached);
        stack.push_back({node.first + 1, visit.depth + 1});
        stack.push_back({node.first, visit.depth + 1});
    }
    return depth;
}

}  // namespace clbvh::trace
