#include "clbvh/layout/pair.hpp"

#include <cmath>

#include "clbvh/core/validate.hpp"
#include "layout/layout_checks.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

PairLayout make(const MeshTree& tree, const LayoutOptions& options = {}) {
    PairLayout layout;
    make_layout(tree.bvh, layout, options);
    return layout;
}

}  // namespace

TEST_CASE("pair: the layout of every tree is proven, and rays hit what they hit in the tree") {
    check_layouts_of_all_scenes(make);
}

TEST_CASE("pair: odd trees") {
    check_layouts_of_odd_trees(make);
    check_layout_of_deep_tree(make);
}

TEST_CASE("pair: trees that are none are refused") {
    check_trees_are_refused(make);
}

TEST_CASE("pair: an example, byte by byte") {
    const MeshTree tree = tree_of_three();
    REQUIRE(clbvh::validate(tree.bvh, Primitives{tree.mesh}).error.empty());
    const PairLayout layout = make(tree);
    const std::vector<PairNode> expected = {{{0, 0, 0}, 1, {5, 1, 0}, 4, {9, 0, 0}, 0, {9, 2, 2}, 0},
                                            {{0, 0, 0}, 2, {1, 1, 0}, 3, {4, 0, 0}, 0, {5, 1, 0}, 0},
                                            {{}, 0, {}, 0, {}, 1, {}, 0},
                                            {{}, 0, {}, 0, {}, 1, {}, 1},
                                            {{}, 0, {}, 0, {}, 1, {}, 2}};
    CHECK(std::vector<PairNode>(layout.nodes.begin(), layout.nodes.end()) == expected);
    CHECK(std::vector<std::uint32_t>(layout.primitive_ids.begin(), layout.primitive_ids.end()) ==
          std::vector<std::uint32_t>{0, 1, 2});
    CHECK(layout.depth == 2);
    CHECK(layout.primitive_count == 3);
    CHECK_FALSE(layout.split_references);
}

TEST_CASE("pair: the same bytes with any number of threads, in new memory and in old") {
    check_threads_and_memory(make);
}

TEST_CASE("pair: trees over boxes") {
    check_trees_over_boxes<PairLayout>();
}

TEST_CASE("pair: a fault in a layout is named") {
    const Mesh mesh = generate_scene("soup", 300);
    const PairLayout valid = make({"", mesh, build(mesh, "sweep-sah")});
    std::size_t leaf = 0;
    while (!valid.nodes[leaf].is_leaf())
        ++leaf;
    const std::string leaf_name = "node " + std::to_string(leaf);
    using Layout = PairLayout;
    const auto last = valid.primitive_ids.size() - 1;
    check_faults_are_named<Layout>(
        valid, mesh,
        {{[](Layout& l) { l.nodes[0].left = 2; }, {"node 1", "has 2 for its number"}},
         {[](Layout& l) { l.nodes[0].right += 1; }, {"for its number"}},
         {[](Layout& l) { l.nodes[0].left_upper[1] -= 1.0f; }, {"node 1", "box"}},
         {[](Layout& l) { l.nodes[1].right_lower[1] = NAN; }, {"node 1", "box"}},
         {[&](Layout& l) { l.nodes[leaf - 1].left_lower[0] = l.nodes[leaf - 1].left_upper[0]; },
          {leaf_name, "not within the leaf's box"}},
         {[&](Layout& l) { l.nodes[leaf].first += 1; }, {leaf_name, "begin at 1"}},
         {[&](Layout& l) { l.nodes[leaf].count = 1000; }, {leaf_name, "are 1000"}},
         {[&](Layout& l) { l.primitive_ids[last] = 300; }, {"primitive 300 is out of range"}},
         {[&](Layout& l) { l.primitive_ids[last] = l.primitive_ids[0]; }, {"a second time"}},
         {[](Layout& l) { l.nodes.resize_for_overwrite(l.nodes.size() - 1); }, {"missing"}},
         {[](Layout& l) { l.nodes[0] = {{}, 0, {}, 0, {}, 1, {}, 0}; }, {"node 1", "behind the last"}},
         {[](Layout& l) { l.nodes.resize_for_overwrite(0); }, {"primitive ids"}},
         {[](Layout& l) { l.depth += 1; }, {"depth"}},
         {[](Layout& l) { l.primitive_count = 301; }, {"primitive_count is 301", "300"}}});
}

TEST_CASE("pair: any bytes can be validated") {
    const Mesh mesh = generate_scene("soup", 100);
    check_any_bytes(make({"", mesh, build(mesh, "sweep-sah")}), mesh);
    check_any_bytes(make({"", mesh, build(mesh, "sbvh")}), mesh);
}
