// Wide trees of the least SAH cost: against all wide trees that there are, and as layouts.
#include <algorithm>
#include <vector>

#include "clbvh/layout/compressed8.hpp"
#include "clbvh/layout/wide.hpp"
#include "layout/layout_checks.hpp"
#include "layout/wide_converter.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr LayoutOptions kLeastCost{.opening = NodeOpening::least_cost};

template <typename Layout>
Layout make(const MeshTree& tree, const LayoutOptions& options = {}) {
    LayoutOptions cheapest = options;
    cheapest.opening = NodeOpening::least_cost;
    return make_layout<Layout>(tree.bvh, tree.mesh, cheapest);
}

/// The SAH cost of a layout: half areas of the boxes of nodes and, a block at a time, of leaves.
template <std::uint32_t Width>
double cost_of(const WideLayout<Width>& layout) {
    double cost = 0.0;
    Aabb root;
    for (const WideNode<Width>& node : layout.nodes) {
        for (std::uint32_t slot = 0; slot < Width; ++slot) {
            if (node.children[slot] == WideChild::kNone) continue;
            const auto corner = [&](std::size_t side) {
                return Vec3{node.bounds[side][0][slot], node.bounds[side][1][slot], node.bounds[side][2][slot]};
            };
            const Aabb box{corner(0), corner(1)};
            const bool is_leaf = WideChild::is_leaf(node.children[slot]);
            const double visits = is_leaf ? WideChild::block_count(node.children[slot]) : 1;
            cost += visits * half_area(box);
            if (&node == layout.nodes.data()) root = merge(root, box);
        }
    }
    return cost + half_area(root);
}

/// Slots of a wide node that hold all that is below a node of the binary tree, and what that costs.
struct Way {
    std::uint32_t slots;
    double cost;
};

/// Every way to put what is below a node, or the pair of its children, into slots.
template <std::uint32_t Width>
class AllWays {
public:
    explicit AllWays(const Bvh& bvh) : bvh_(bvh) {}

    [[nodiscard]] double least_cost() const {
        double least = 1e300;
        for (const Way& way : of_children(0))
            if (way.slots <= Width) least = std::min(least, way.cost + area(0));
        // A root of one leaf has that for its only child.
        const std::uint32_t count = primitives(0);
        if (bvh_.nodes[0].is_leaf() || count <= 4) least = std::min(least, area(0) * (1 + (count + 3) / 4));
        return least;
    }

private:
    [[nodiscard]] double area(std::uint32_t node) const { return half_area(bvh_.nodes[node].bounds()); }

    [[nodiscard]] std::uint32_t primitives(std::uint32_t node) const {
        const Node& n = bvh_.nodes[node];
        return n.is_leaf() ? n.count : primitives(n.first) + primitives(n.first + 1);
    }

    [[nodiscard]] std::vector<Way> of_children(std::uint32_t node) const {
        std::vector<Way> ways;
        if (bvh_.nodes[node].is_leaf()) return ways;
        const std::vector<Way> right = of_node(bvh_.nodes[node].first + 1);
        for (const Way& a : of_node(bvh_.nodes[node].first)) {
            for (const Way& b : right)
                ways.push_back({a.slots + b.slots, a.cost + b.cost});
        }
        return ways;
    }

    [[nodiscard]] std::vector<Way> of_node(std::uint32_t node) const {
        const Node& n = bvh_.nodes[node];
        if (n.is_leaf()) return {{1, area(node) * ((n.count + 3) / 4)}};
        std::vector<Way> ways = of_children(node);
        std::erase_if(ways, [](const Way& way) { return way.slots > Width; });
        for (std::size_t i = 0, end = ways.size(); i < end; ++i)
            ways.push_back({1, ways[i].cost + area(node)});
        if (primitives(node) <= 4) ways.push_back({1, area(node)});
        return ways;
    }

    const Bvh& bvh_;
};

template <std::uint32_t Width>
void check_cost(const Bvh& bvh, const Mesh& mesh) {
    const auto layout = make_layout<WideLayout<Width>>(bvh, mesh, kLeastCost);
    const double least = AllWays<Width>(bvh).least_cost();
    INFO("width " << Width << ", cost " << cost_of(layout) << ", least " << least);
    CHECK_NOTHROW(validate(layout, mesh));
    CHECK(cost_of(layout) == Approx(least).epsilon(1e-5));
    CHECK(least <= cost_of(make_layout<WideLayout<Width>>(bvh, mesh)) * 1.00001);
}

}  // namespace

TEST_CASE("least cost: no other opening of a small tree is cheaper") {
    for (const std::uint32_t count : {1u, 2u, 3u, 5u, 7u, 9u, 11u}) {
        for (const char* const scene : {"soup", "hair", "city"}) {
            for (const std::uint64_t seed : {1u, 2u, 3u, 4u}) {
                const Mesh mesh = generate_scene(scene, count, seed);
                for (const char* const id : {"sweep-sah", "median"}) {
                    INFO(scene << ' ' << count << ' ' << seed << ' ' << id);
                    const Bvh bvh = build(mesh, id);
                    check_cost<4>(bvh, mesh);
                    if (count < 11) check_cost<8>(bvh, mesh);
                }
                check_cost<4>(chain_tree(mesh), mesh);
                check_cost<8>(chain_tree(mesh), mesh);
            }
        }
    }
}

TEST_CASE("least cost: the openings of real trees are cheaper than largest first") {
    const Mesh mesh = generate_scene("city", 20'000);
    for (const char* const id : {"binned-sah", "median", "sbvh"}) {
        const Bvh bvh = build(mesh, id);
        CHECK(cost_of(make_layout<Wide8>(bvh, mesh, kLeastCost)) < 0.999 * cost_of(make_layout<Wide8>(bvh, mesh)));
        CHECK(cost_of(make_layout<Wide4>(bvh, mesh, kLeastCost)) < 0.999 * cost_of(make_layout<Wide4>(bvh, mesh)));
    }
}

TEST_CASE("least cost: the layout of every tree is proven, and rays hit what they hit in the tree") {
    check_layouts_of_all_scenes(make<Wide8>);
    check_layouts_of_all_scenes(make<Wide4>);
    check_layouts_of_all_scenes(make<Compressed8>);
}

TEST_CASE("least cost: odd trees") {
    check_layouts_of_odd_trees(make<Wide8>);
    check_layouts_of_odd_trees(make<Wide4>);
    check_layouts_of_odd_trees(make<Compressed8>);
    check_layout_of_deep_tree(make<Wide8>);
    check_layout_of_deep_tree(make<Compressed8>);
}

TEST_CASE("least cost: the same bytes with any number of threads, in new memory and in old") {
    const Mesh mesh = generate_scene("city", 60'000), small = generate_scene("hair", 100);
    const Bvh bvh = build(mesh, "sbvh"), small_bvh = build(small, "median");
    const MeshTree tree{"", mesh, bvh};
    const Wide8 expected = make<Wide8>(tree, {.thread_count = 1});
    const Compressed8 compressed = make<Compressed8>(tree, {.thread_count = 1});
    layout::WideConverter<8> converter;
    Wide8 again;
    for (const std::uint32_t threads : {0u, 2u, 7u}) {
        const Wide8 wide = make<Wide8>(tree, {.thread_count = threads});
        CHECK(same_elements(wide.nodes, expected.nodes));
        CHECK(same_elements(wide.blocks, expected.blocks));
        CHECK(same_elements(make<Compressed8>(tree, {.thread_count = threads}).nodes, compressed.nodes));
        converter.run(layout::view_of(bvh), mesh, again, NodeOpening::least_cost);
        CHECK(same_elements(again.nodes, expected.nodes));
        converter.run(layout::view_of(small_bvh), small, again, NodeOpening::least_cost);
        CHECK_NOTHROW(validate(again, small));
        converter.run(layout::view_of(small_bvh), small, again);
        CHECK(same_elements(again.nodes, make_layout<Wide8>(small_bvh, small).nodes));
    }
}
