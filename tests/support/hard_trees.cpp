#include "support/hard_trees.hpp"

#include <algorithm>
#include <cmath>

namespace clbvh::test {

std::vector<LeafContent> leaves_of(const Bvh& tree) {
    std::vector<LeafContent> leaves;
    std::vector<std::uint32_t> stack;
    if (!tree.empty()) stack.push_back(0);
    while (!stack.empty()) {
        const Node node = tree.nodes[stack.back()];
        stack.pop_back();
        if (node.is_leaf()) {
            const auto begin = tree.primitive_ids.begin() + node.first;
            leaves.push_back(
                {std::vector<std::uint32_t>(begin, begin + node.count),
                 {node.lower[0], node.lower[1], node.lower[2], node.upper[0], node.upper[1], node.upper[2]}});
        } else {
            stack.insert(stack.end(), {node.first, node.first + 1});
        }
    }
    std::ranges::sort(leaves);
    return leaves;
}

Bvh chain_tree(const Mesh& mesh) {
    const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
    Bvh tree;
    tree.primitive_count = count;
    tree.nodes.resize(2 * std::size_t{count});
    for (std::uint32_t i = 0; i < count; ++i)
        tree.primitive_ids.push_back(i);
    const auto set = [&](std::uint32_t slot, const Aabb& box, std::uint32_t first, std::uint32_t primitives) {
        tree.nodes[slot] = {
            {box.lower.x, box.lower.y, box.lower.z}, first, {box.upper.x, box.upper.y, box.upper.z}, primitives};
    };
    Aabb below = triangle_bounds(mesh, count - 1);
    set(2 * (count - 1), below, count - 1, 1);
    for (std::uint32_t i = count - 1; i > 0; --i) {
        const Aabb box = triangle_bounds(mesh, i - 1);
        set(2 * i + 1, box, i - 1, 1);
        below = merge(below, box);
        set(i > 1 ? 2 * (i - 1) : 0, below, 2 * i, 0);
    }
    return tree;
}

Mesh line_of_points(std::uint32_t count) {
    Mesh mesh;
    for (std::uint32_t i = 0; i < count; ++i) {
        mesh.vertices.push_back({static_cast<float>((i * 7919) % count), 0.0f, 0.0f});
        mesh.triangles.push_back({i, i, i});
    }
    return mesh;
}

std::array<Mesh, 5> flat_and_other_frames(const Mesh& line) {
    Mesh curve = line;
    for (Vec3& vertex : curve.vertices)
        vertex = {vertex.x, 100.0f * std::sin(0.1f * vertex.x), 100.0f * std::cos(0.1f * vertex.x)};
    Mesh point = line;
    for (Vec3& vertex : point.vertices)
        vertex = {3.0f, -1.0f, 2.0f};
    return {curve, line, point, curve, line};
}

Bvh with_strays(const Bvh& tree) {
    Bvh sparse = tree;
    sparse.nodes.assign(2 * tree.nodes.size(), Node{{-9, -9, -9}, 2, {9, 9, 9}, 0});
    for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
        Node node = tree.nodes[i];
        if (!node.is_leaf()) node.first *= 2;
        sparse.nodes[i < 2 ? i : i / 2 * 4 + i % 2] = node;
    }
    sparse.nodes[1] = {};
    return sparse;
}

}  // namespace clbvh::test
