#include "clbvh/layout/skip.hpp"

#include "clbvh/core/validate.hpp"
#include "layout/layout_checks.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

SkipLayout make(const MeshTree& tree, const LayoutOptions& options = {}) {
    SkipLayout layout;
    make_layout(tree.bvh, layout, options);
    return layout;
}

}  // namespace

TEST_CASE("skip: the layout of every tree is proven, and rays hit what they hit in the tree") {
    check_layouts_of_all_scenes(make);
}

TEST_CASE("skip: odd trees") {
    check_layouts_of_odd_trees(make);
    check_layout_of_deep_tree(make);
}

TEST_CASE("skip: trees that are none are refused") {
    check_trees_are_refused(make);
}

TEST_CASE("skip: an example, byte by byte") {
    const MeshTree tree = tree_of_three();
    REQUIRE(clbvh::validate(tree.bvh, Primitives{tree.mesh}).error.empty());
    const SkipLayout layout = make(tree);
    const std::vector<SkipNode> expected = {{{0, 0, 0}, 5, {9, 2, 2}, 0},
                                            {{0, 0, 0}, 4, {5, 1, 0}, 0},
                                            {{0, 0, 0}, 0, {1, 1, 0}, 1},
                                            {{4, 0, 0}, 1, {5, 1, 0}, 1},
                                            {{9, 0, 0}, 2, {9, 2, 2}, 1}};
    CHECK(std::vector<SkipNode>(layout.nodes.begin(), layout.nodes.end()) == expected);
    CHECK(std::vector<std::uint32_t>(layout.primitive_ids.begin(), layout.primitive_ids.end()) ==
          std::vector<std::uint32_t>{0, 1, 2});
    CHECK(layout.depth == 2);
    CHECK(layout.primitive_count == 3);
    CHECK_FALSE(layout.split_references);
}

TEST_CASE("skip: the same bytes with any number of threads, in new memory and in old") {
    check_threads_and_memory(make);
}

TEST_CASE("skip: trees over boxes") {
    check_trees_over_boxes<SkipLayout>();
}

TEST_CASE("skip: a fault in a layout is named") {
    const Mesh mesh = generate_scene("soup", 300);
    const SkipLayout valid = make({"", mesh, build(mesh, "sweep-sah")});
    std::size_t leaf = 0;
    while (!valid.nodes[leaf].is_leaf())
        ++leaf;
    const std::string leaf_name = "node " + std::to_string(leaf);
    using Layout = SkipLayout;
    const auto last = valid.primitive_ids.size() - 1;
    check_faults_are_named<Layout>(
        valid, mesh,
        {{[](Layout& l) { l.nodes[0].link -= 1; }, {"node 0", "root"}},
         {[](Layout& l) { l.nodes[1].link = 0; }, {"node 1", "no room"}},
         {[](Layout& l) { l.nodes[1].link = l.nodes[0].link; }, {"node 1", "node 0"}},
         {[](Layout& l) { l.nodes[l.nodes[1].link].count = 1; }, {"node"}},
         {[](Layout& l) { l.nodes[1].upper[2] += 1.0f; }, {"node 1", "box"}},
         {[&](Layout& l) { l.nodes[leaf].lower[0] = l.nodes[leaf].upper[0]; },
          {leaf_name, "not within the leaf's box"}},
         {[&](Layout& l) { l.nodes[leaf].link += 1; }, {leaf_name, "begin at 1"}},
         {[&](Layout& l) { l.nodes[leaf].count = 1000; }, {leaf_name, "are 1000"}},
         {[&](Layout& l) { l.primitive_ids[last] = 300; }, {"primitive 300 is out of range"}},
         {[&](Layout& l) { l.primitive_ids[last] = l.primitive_ids[0]; }, {"a second time"}},
         {[](Layout& l) { l.nodes.resize_for_overwrite(l.nodes.size() - 1); }, {"root's link"}},
         {[](Layout& l) { l.nodes.resize_for_overwrite(0); }, {"primitive ids"}},
         {[](Layout& l) { l = SkipLayout{}; }, {"primitive_count is 0"}},
         {[](Layout& l) {
              l = SkipLayout{};
              l.primitive_count = 300;
          },
          {"primitive 0 is in no leaf"}},
         {[](Layout& l) { l.depth += 1; }, {"depth"}},
         {[](Layout& l) { l.primitive_count = 301; }, {"primitive_count is 301", "300"}}});
}

TEST_CASE("skip: a part of a split triangle that is lost is found") {
    const Mesh mesh = generate_scene("hair", 300);
    const SkipLayout valid = make({"", mesh, build(mesh, "sbvh")});
    REQUIRE(valid.split_references);
    check_faults_are_named<SkipLayout>(valid, mesh,
                                       {{[](SkipLayout& l) {
                                             for (SkipNode& node : l.nodes)
                                                 if (node.is_leaf()) node.upper[0] = node.lower[0];
                                         },
                                         {"the part of it around", "is in none of the leaves"}}});
}

TEST_CASE("skip: any bytes can be validated") {
    const Mesh mesh = generate_scene("soup", 100);
    check_any_bytes(make({"", mesh, build(mesh, "sweep-sah")}), mesh);
    check_any_bytes(make({"", mesh, build(mesh, "sbvh")}), mesh);
}
