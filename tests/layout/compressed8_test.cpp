#include "clbvh/layout/compressed8.hpp"

#include <cmath>

#include "clbvh/core/validate.hpp"
#include "layout/layout_checks.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

Compressed8 make(const MeshTree& tree, const LayoutOptions& options = {}) {
    Compressed8 layout;
    make_layout(tree.bvh, tree.mesh, layout, options);
    return layout;
}

}  // namespace

TEST_CASE("compressed8: the layout of every tree is proven, and rays hit what they hit in the tree") {
    check_layouts_of_all_scenes(make);
}

TEST_CASE("compressed8: odd trees") {
    check_layouts_of_odd_trees(make);
    check_layout_of_deep_tree(make);
}

TEST_CASE("compressed8: large and small scenes, and ones far from the origin") {
    const Mesh mesh = generate_scene("city", 1000);
    for (const float factor : {largest_scale(mesh), 0x1p-100f, 0x1p-130f}) {
        const Mesh other = scaled(mesh, factor);
        const MeshTree tree{"scale " + std::to_string(factor), other, build(other, "binned-sah")};
        CHECK_NOTHROW(validate(make(tree), other));
    }
    Mesh moved = mesh;
    for (Vec3& v : moved.vertices)
        v = {v.x + 1e6f, v.y - 3e5f, v.z + 77.0f};
    check_layout({"moved", moved, build(moved, "binned-sah")}, 20, make);
}

TEST_CASE("compressed8: an example, byte by byte") {
    const Mesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {250, 0, 0}, {255, 0, 0}, {250, 2.5f, 0}},
                    {{0, 1, 2}, {3, 4, 5}, {3, 5, 4}, {5, 4, 3}, {4, 5, 3}}};
    Bvh tree;
    tree.primitive_count = 5;
    tree.primitive_ids = {4, 3, 2, 1, 0};
    tree.nodes = {{{0, 0, 0}, 2, {255, 2.5f, 0}, 0},   {},  // root
                  {{0, 0, 0}, 4, {1, 1, 0}, 1},        {{250, 0, 0}, 4, {255, 2.5f, 0}, 0},
                  {{250, 0, 0}, 2, {255, 2.5f, 0}, 2}, {{250, 0, 0}, 0, {255, 2.5f, 0}, 2}};
    REQUIRE(clbvh::validate(tree, Primitives{mesh}).error.empty());
    const Compressed8 layout = make({"", mesh, tree});
    REQUIRE(layout.nodes.size() == 1);
    const Compressed8Node& root = layout.nodes[0];
    CHECK(root.origin == std::array<float, 3>{0, 0, 0});
    CHECK(root.exponent == std::array<std::int8_t, 3>{0, -6, -126});
    CHECK(root.inner_mask == 0);
    CHECK(root.first_child == 0);
    CHECK(root.first_triangle == 0);
    // Triangle 0 is on the lower side of x, the leaves with two are on its upper side.
    CHECK(root.meta == std::array<std::uint8_t, 8>{0x20, 0, 0, 0, 0x61, 0x63, 0, 0});
    CHECK(root.lower[0] == std::array<std::uint8_t, 8>{0, 0, 0, 0, 250, 250, 0, 0});
    CHECK(root.upper[0] == std::array<std::uint8_t, 8>{1, 0, 0, 0, 255, 255, 0, 0});
    CHECK(root.lower[1] == std::array<std::uint8_t, 8>{});
    CHECK(root.upper[1] == std::array<std::uint8_t, 8>{64, 0, 0, 0, 160, 160, 0, 0});
    CHECK(root.lower[2] == std::array<std::uint8_t, 8>{});
    CHECK(root.upper[2] == std::array<std::uint8_t, 8>{});
    CHECK(root.bounds(4) == Aabb{{250, 0, 0}, {255, 2.5f, 0}});
    const std::array<std::uint32_t, 5> primitives = {0, 2, 1, 4, 3};
    REQUIRE(layout.triangles.size() == 5);
    for (std::size_t i = 0; i < 5; ++i)
        CHECK(layout.triangles[i].primitive == primitives[i]);
    const Compressed8Triangle& second = layout.triangles[1];
    CHECK(second.edge2 == std::array<float, 3>{5, 0, 0});
    CHECK(second.edge1 == std::array<float, 3>{0, 2.5f, 0});
    CHECK(second.vertex0 == std::array<float, 3>{250, 0, 0});
    CHECK(second.zero0 == 0);
    CHECK(second.zero1 == 0);
    CHECK(layout.depth == 1);
}

TEST_CASE("compressed8: the same bytes with any number of threads, in new memory and in old") {
    for (const char* const builder : {"binned-sah", "sbvh"}) {
        const Mesh mesh = generate_scene("city", 60'000);
        const MeshTree tree{"", mesh, build(mesh, builder)};
        const Compressed8 expected = make(tree, {.thread_count = 1});
        CHECK_NOTHROW(validate(expected, mesh));
        CHECK(count_other_hits(tree, expected, 10) == 0);
        Compressed8 layout = make({"", random_triangles(7), build(random_triangles(7), "median")});
        for (const std::uint32_t threads : {0u, 2u, 7u}) {
            make_layout(tree.bvh, mesh, layout, {.thread_count = threads, .check = threads != 2});
            CHECK(same_elements(layout.nodes, expected.nodes));
            CHECK(same_elements(layout.triangles, expected.triangles));
            CHECK(layout.depth == expected.depth);
        }
    }
}

TEST_CASE("compressed8: rays visit fewer nodes in the order of their octant's slots") {
    const Mesh mesh = generate_scene("soup", 20'000);
    const Compressed8 layout = make({"", mesh, build(mesh, "binned-sah")});
    OrderCosts sum;
    for (const Ray& ray : difficult_rays(mesh, 100)) {
        const OrderCosts costs = order_costs(layout, mesh, ray);
        sum.in_order += costs.in_order;
        sum.backwards += costs.backwards;
    }
    CHECK(static_cast<double>(sum.in_order) < 0.9 * static_cast<double>(sum.backwards));
}

TEST_CASE("compressed8: a mesh and a tree that do not go together are refused") {
    const Mesh mesh = random_triangles(100);
    const Bvh tree = build(mesh, "median");
    Compressed8 layout = make({"", mesh, tree});
    const auto expect_refused = [&](const Bvh& bvh, const Mesh& other, std::initializer_list<std::string> words) {
        expect_error(ErrorCode::invalid_input, words, [&] { make_layout(bvh, other, layout); });
        CHECK(layout.empty());
        CHECK(layout.triangles.empty());
    };
    expect_refused(tree, random_triangles(99), {"100 primitives", "99 triangles"});
    Bvh broken = tree;
    broken.nodes[0].first = 7;
    expect_refused(broken, mesh, {"node 0"});
    expect_error(ErrorCode::invalid_input, {"thread_count"}, [&] { make({"", mesh, tree}, {.thread_count = 2000}); });
}

TEST_CASE("compressed8: a fault in a layout is named") {
    const Mesh mesh = generate_scene("soup", 300);
    using Layout = Compressed8;
    const Layout valid = make({"", mesh, build(mesh, "sweep-sah")});
    std::uint32_t inner = 0, leaf = 0, leaf_node = 0;
    while (!valid.nodes[0].is_inner(inner))
        ++inner;
    const auto is_leaf = [&] {
        return !valid.nodes[leaf_node].is_empty(leaf) && !valid.nodes[leaf_node].is_inner(leaf);
    };
    for (; !is_leaf(); leaf_node += leaf / 8, leaf %= 8)
        ++leaf;
    const std::string name = "node " + std::to_string(leaf_node);
    check_faults_are_named<Layout>(
        valid, mesh,
        {{[&](Layout& l) { l.nodes[0].first_child = 1u << 31; }, {"node 0", "out of range"}},
         {[&](Layout& l) { l.nodes[0].first_child = 0; }, {"node 0", "another parent"}},
         {[&](Layout& l) { l.nodes[0].meta[inner] ^= 1; }, {"node 0", "meta of slot " + std::to_string(inner)}},
         {[&](Layout& l) { l.nodes[0].exponent[1] = -127; }, {"node 0", "exponent is -127"}},
         {[&](Layout& l) { l.nodes[0].exponent[1] -= 1; }, {"not within the leaf's box"}},
         {[&](Layout& l) { l.nodes[0].lower[2][inner] += 20; }, {"not within the leaf's box"}},
         {[&](Layout& l) { l.nodes[leaf_node].upper[0][leaf] -= 1; }, {name, "not within the leaf's box"}},
         {[&](Layout& l) { l.nodes[leaf_node].origin[0] = NAN; }, {"not within the leaf's box"}},
         {[&](Layout& l) {
              l.nodes[leaf_node].meta[leaf] |= 0xA0;
              l.nodes[leaf_node].meta[leaf] &= 0xBF;
          },
          {name, "meta"}},
         {[&](Layout& l) { l.nodes[leaf_node].meta[leaf] ^= 2; }, {name, "meta"}},
         {[&](Layout& l) { l.nodes[leaf_node].first_triangle += 1; }, {name, "no multiple of 3"}},
         {[&](Layout& l) { l.nodes[leaf_node].first_triangle = 3 * 1000; }, {name, "too far behind"}},
         {[&](Layout& l) { l.nodes[leaf_node].first_triangle += 3; }, {"triangle"}},
         {[](Layout& l) { l.triangles[5].primitive = 300; }, {"primitive 300 is out of range"}},
         {[](Layout& l) { l.triangles[5].primitive = l.triangles[6].primitive; }, {"primitive"}},
         {[](Layout& l) { l.triangles[5].edge1[2] += 1.0f; }, {"triangle 5", "not that of primitive"}},
         {[](Layout& l) { l.triangles[5].vertex0[0] += 1.0f; }, {"triangle 5", "not that of primitive"}},
         {[](Layout& l) { l.triangles.resize_for_overwrite(299); }, {"too far behind"}},
         {[](Layout& l) { l.nodes.resize_for_overwrite(0); }, {"triangle 0 is not part"}},
         {[](Layout& l) { l = {}; }, {"primitive_count is 0"}},
         {[](Layout& l) { l.depth += 1; }, {"depth"}}});
}

TEST_CASE("compressed8: a part of a split triangle that is lost is found") {
    const Mesh mesh = generate_scene("hair", 300);
    const Compressed8 valid = make({"", mesh, build(mesh, "sbvh")});
    REQUIRE(valid.split_references);
    check_faults_are_named<Compressed8>(valid, mesh,
                                        {{[](Compressed8& l) {
                                              for (Compressed8Node& node : l.nodes)
                                                  for (std::uint32_t slot = 0; slot < 8; ++slot)
                                                      if (!node.is_empty(slot) && !node.is_inner(slot))
                                                          node.upper[0][slot] = node.lower[0][slot];
                                          },
                                          {"the part of it around", "is in none of the leaves"}}});
}

TEST_CASE("compressed8: any bytes can be validated") {
    const Mesh mesh = generate_scene("soup", 100);
    check_any_bytes(make({"", mesh, build(mesh, "sweep-sah")}), mesh);
    check_any_bytes(make({"", mesh, build(mesh, "sbvh")}), mesh);
}
