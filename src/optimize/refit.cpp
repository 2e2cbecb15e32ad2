#include "clbvh/optimize/refit.hpp"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <string>
#include <vector>

#include "clbvh/core/error.hpp"
#include "core/bottom_up.hpp"
#include "core/memory_errors.hpp"
#include "metrics/check_costs.hpp"
#include "optimize/edit_tree.hpp"

namespace clbvh {
namespace {

[[noreturn]] void refuse(const std::string& what) {
    throw Error(ErrorCode::invalid_input, what);
}

/// Which triangles the tree's leaves name.
std::vector<bool> named_triangles(const Bvh& tree) {
    std::vector<bool> named(tree.primitive_count);
    for (const std::uint32_t id : tree.primitive_ids) {
        if (id >= named.size()) refuse("the tree names triangle " + std::to_string(id) + ", which it cannot have");
        named[id] = true;
    }
    return named;
}

/// Throws unless the mesh's active triangles are those of the tree.
void check_same_triangles(const Bvh& tree, const Mesh& mesh) {
    if (mesh.triangles.size() != tree.primitive_count) {
        refuse("the mesh has " + std::to_string(mesh.triangles.size()) + " triangles, but the tree was built over " +
               std::to_string(tree.primitive_count) + "; build anew");
    }
    const std::uint64_t inactive = check_mesh(mesh);
    // The common case; duplicates and holes among the ids would need a broken tree.
    if (inactive == 0 && !tree.split_references && tree.primitive_ids.size() == tree.primitive_count) return;
    const std::vector<bool> named = named_triangles(tree);
    for (std::size_t i = 0; i < named.size(); ++i) {
        if (named[i] != is_inactive(mesh, i)) continue;
        refuse("triangle " + std::to_string(i) + (named[i] ? " has a NaN now, but is" : " had a NaN, and is not") +
               " in the tree; build anew");
    }
}

/// Sums of area times cost; divided by the root's area they are the tree's SAH cost.
struct Costs {
    double before = 0.0;
    double after = 0.0;
};

class Refitter {
public:
    Refitter(Bvh& tree, const Mesh& mesh, const SahCosts& costs) : tree_(tree), mesh_(mesh), costs_(costs) {}

    RefitStats run() {
        Node& root = tree_.nodes[0];
        const double area_before = optimizer::exact_half_area(root);
        if (root.is_leaf()) {
            Costs& sums = sums_.local();
            refit_leaf(root, sums);
        } else {
            Scratch scratch;
            const auto visit = [this](std::uint32_t node) { refit_inner(node); };
            BottomUp<decltype(visit)>(tree_.nodes, scratch, visit).run();
        }
        const Costs sums = sums_.combine([](const Costs& a, const Costs& b) {
            return Costs{a.before + b.before, a.after + b.after};
        });
        return {relative(sums.before, area_before), relative(sums.after, optimizer::exact_half_area(root))};
    }

private:
    static double relative(double sum, double root_area) { return root_area > 0.0 ? sum / root_area : 0.0; }

    void refit_inner(std::uint32_t index) {
        Node& node = tree_.nodes[index];
        Costs& sums = sums_.local();
        Node& left = tree_.nodes[node.first];
        Node& right = tree_.nodes[std::size_t{node.first} + 1];
        if (left.is_leaf()) refit_leaf(left, sums);
        if (right.is_leaf()) refit_leaf(right, sums);
        Box4 box = Box4::of(left);
        box.merge(Box4::of(right));
        replace(node, make_node(box, node.first, 0), costs_.inner, sums);
    }

    void refit_leaf(Node& leaf, Costs& sums) {
        Aabb box;
        for (std::uint32_t i = leaf.first; i < leaf.first + leaf.count; ++i)
            box = merge(box, triangle_bounds(mesh_, tree_.primitive_ids[i]));
        // Adding +0 turns -0 into +0, and changes nothing else.
        const Node fitted{{box.lower.x + 0.0f, box.lower.y + 0.0f, box.lower.z + 0.0f},
                          leaf.first,
                          {box.upper.x + 0.0f, box.upper.y + 0.0f, box.upper.z + 0.0f},
                          leaf.count};
        replace(leaf, fitted, costs_.primitive * leaf.count, sums);
    }

    static void replace(Node& node, const Node& fitted, double cost, Costs& sums) {
        sums.before += cost * optimizer::exact_half_area(node);
        sums.after += cost * optimizer::exact_half_area(fitted);
        node = fitted;
    }

    Bvh& tree_;
    const Mesh& mesh_;
    SahCosts costs_;
    tbb::enumerable_thread_specific<Costs> sums_;
};

}  // namespace

RefitStats refit(Bvh& tree, const Mesh& mesh, const SahCosts& costs) {
    return with_memory_errors("refitting", [&] {
        check_costs(costs);
        check_same_triangles(tree, mesh);
        return tree.empty() ? RefitStats{} : Refitter(tree, mesh, costs).run();
    });
}

}  // namespace clbvh
