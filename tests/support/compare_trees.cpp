#include "support/compare_trees.hpp"

#include <algorithm>
#include <sstream>
#include <vector>

namespace clbvh::test {
namespace {

/// A pair of nodes at the same place in both trees.
struct Visit {
    std::size_t a;
    std::size_t b;
    std::size_t parent;  ///< Index of the parents' visit; its own for the roots.
    bool right;          ///< Is the second child.
};

std::string path_to(const std::vector<Visit>& visits, std::size_t index) {
    std::string path;
    for (; visits[index].parent != index; index = visits[index].parent) {
        path.insert(0, visits[index].right ? "/right" : "/left");
    }
    return "root" + path;
}

std::string show(const Node& node) {
    std::ostringstream text;
    text.precision(9);
    text << "[" << node.lower[0] << " " << node.lower[1] << " " << node.lower[2] << " to " << node.upper[0] << " "
         << node.upper[1] << " " << node.upper[2] << "]";
    return text.str();
}

bool has_children(const Bvh& bvh, const Node& node) {
    return std::size_t{node.first} + 1 < bvh.nodes.size();
}

bool has_primitives(const Bvh& bvh, const Node& node) {
    return std::size_t{node.first} + node.count <= bvh.primitive_ids.size();
}

std::string compare_leaves(const Bvh& a, const Node& x, const Bvh& b, const Node& y) {
    if (!has_primitives(a, x) || !has_primitives(b, y)) return "primitives out of range";
    for (std::size_t i = 0; i < x.count; ++i) {
        const std::uint32_t p = a.primitive_ids[x.first + i];
        const std::uint32_t q = b.primitive_ids[y.first + i];
        if (p != q) return "primitive " + std::to_string(p) + " against " + std::to_string(q);
    }
    return {};
}

std::string compare_nodes(const Bvh& a, const Node& x, const Bvh& b, const Node& y) {
    if (x.count != y.count) return "count " + std::to_string(x.count) + " against " + std::to_string(y.count);
    if (x.bounds() != y.bounds()) return "box " + show(x) + " against " + show(y);
    if (x.is_leaf()) return compare_leaves(a, x, b, y);
    if (!has_children(a, x) || !has_children(b, y)) return "children out of range";
    return {};
}

}  // namespace

std::string compare_trees(const Bvh& a, const Bvh& b) {
    if (a.primitive_count != b.primitive_count) return "the trees are over different numbers of primitives";
    if (a.empty() != b.empty()) return a.empty() ? "only the first tree is empty" : "only the second tree is empty";
    if (a.empty()) return {};
    std::vector<Visit> visits{{0, 0, 0, false}};
    for (std::size_t i = 0; i < visits.size(); ++i) {
        const auto [index_a, index_b, parent, right] = visits[i];
        const Node& x = a.nodes[index_a];
        const Node& y = b.nodes[index_b];
        const std::string difference = compare_nodes(a, x, b, y);
        if (!difference.empty()) return path_to(visits, i) + ": " + difference;
        if (x.is_leaf()) continue;
        if (visits.size() > a.nodes.size()) return path_to(visits, i) + ": more nodes are reached than there are";
        visits.push_back({x.first, y.first, i, false});
        visits.push_back({std::size_t{x.first} + 1, std::size_t{y.first} + 1, i, true});
    }
    return {};
}

bool same_topology(const Bvh& a, const Bvh& b) {
    const auto same = [](const Node& x, const Node& y) { return x.first == y.first && x.count == y.count; };
    return a.primitive_ids == b.primitive_ids && std::ranges::equal(a.nodes, b.nodes, same);
}

}  // namespace clbvh::test
