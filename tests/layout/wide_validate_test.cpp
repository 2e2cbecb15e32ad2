// Proofs of layouts of eight and of four children a node, and what they find.
#include <cmath>
#include <limits>

#include "clbvh/layout/wide.hpp"
#include "layout/layout_checks.hpp"
#include "support/builders.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

template <typename Layout>
Layout make(const MeshTree& tree, const LayoutOptions& options = {}) {
    Layout layout;
    make_layout(tree.bvh, tree.mesh, layout, options);
    return layout;
}

constexpr auto make_wide8 = make<Wide8>;
constexpr auto make_wide4 = make<Wide4>;

constexpr std::uint32_t kNone = WideChild::kNone;

struct Slot {
    std::size_t node = 0;
    std::uint32_t child = 0;

    [[nodiscard]] std::string node_name() const { return "node " + std::to_string(node); }
    [[nodiscard]] std::string name() const { return node_name() + ", child " + std::to_string(child); }
    template <typename Layout>
    std::uint32_t& in(Layout& layout) const {
        return layout.nodes[node].children[child];
    }
};

/// The first child that is as asked for.
template <typename Layout, typename Is>
Slot find_slot(const Layout& layout, const Is& is) {
    for (std::size_t node = 0;; ++node) {
        for (std::uint32_t child = 0; child < layout.nodes[node].children.size(); ++child)
            if (is(node, layout.nodes[node].children[child])) return {node, child};
    }
}

template <typename Layout>
Slot find_inner(const Layout& layout) {
    return find_slot(layout,
                     [&](std::size_t node, std::uint32_t child) { return node > 0 && !WideChild::is_leaf(child); });
}

/// A leaf of one block.
template <typename Layout>
Slot find_leaf(const Layout& layout) {
    return find_slot(layout, [](std::size_t, std::uint32_t child) {
        return child != kNone && WideChild::is_leaf(child) && WideChild::block_count(child) == 1;
    });
}

/// The first of two leaves in one node.
template <typename Layout>
Slot find_two_leaves(const Layout& layout) {
    return find_slot(layout, [&](std::size_t node, const std::uint32_t& child) {
        const auto& children = layout.nodes[node].children;
        return &child != &children.back() && child != kNone && WideChild::is_leaf(child) && *(&child + 1) != kNone &&
               WideChild::is_leaf(*(&child + 1));
    });
}

/// A child once more in the place of the one behind it.
template <std::uint32_t Width>
void copy_to_next(WideNode<Width>& node, std::uint32_t child) {
    node.children[child + 1] = node.children[child];
    for (auto& side : node.bounds) {
        for (auto& axis : side)
            axis[child + 1] = axis[child];
    }
}

template <typename Layout>
std::vector<Fault<Layout>> child_faults(const Layout& valid) {
    const Slot inner = find_inner(valid), leaf = find_leaf(valid), two = find_two_leaves(valid);
    const auto last_node = static_cast<std::uint32_t>(valid.nodes.size() - 1);
    const auto last_block = static_cast<std::uint32_t>(valid.blocks.size() - 1);
    return {
        {[=](Layout& l) { inner.in(l) = last_node + 1; }, {inner.name(), "out of range"}},
        {[=](Layout& l) { inner.in(l) = 0x7FFFFFFF; }, {inner.name(), "out of range"}},
        {[=](Layout& l) { inner.in(l) = 0; }, {inner.name(), "no higher number"}},
        {[=](Layout& l) { inner.in(l) = static_cast<std::uint32_t>(inner.node); }, {inner.name(), "no higher number"}},
        {[=](Layout& l) { inner.in(l) -= 1; }, {inner.node_name(), "another parent"}},
        {[=](Layout& l) { l.nodes[0].children[1] = l.nodes[0].children[0]; }, {"node 0, child 1"}},
        {[=](Layout& l) { copy_to_next(l.nodes[two.node], two.child); },
         {Slot{two.node, two.child + 1}.name(), "block", "is in another leaf"}},
        {[](Layout& l) { l.nodes[0].children.fill(kNone); }, {"node 0", "no child"}},
        {[](Layout& l) { l.nodes[0].children[1] = kNone; }, {"node 0, child 2", "behind one that is none"}},
        {[=](Layout& l) { leaf.in(l) = WideChild::leaf(last_block + 1, 1); }, {leaf.name(), "out of range"}},
        {[=](Layout& l) { leaf.in(l) = WideChild::leaf(last_block, 2); }, {leaf.name(), "2 blocks"}},
        {[=](Layout& l) { leaf.in(l) = WideChild::leaf(WideChild::kFirstBlockMask, 7); },
         {leaf.name(), "out of range"}}};
}

template <typename Layout>
std::vector<Fault<Layout>> box_faults(const Layout& valid) {
    constexpr float inf = std::numeric_limits<float>::infinity();
    const Slot inner = find_inner(valid), leaf = find_leaf(valid);
    const Slot gap = find_slot(valid, [](std::size_t, std::uint32_t child) { return child == kNone; });
    const std::string no_child = "child " + std::to_string(valid.nodes[0].children.size() - 1);
    return {{[=](Layout& l) { l.nodes[inner.node].bounds[1][2][inner.child] += 1000.0f; }, {inner.name(), "box"}},
            {[=](Layout& l) { l.nodes[inner.node].bounds[0][0][inner.child] = NAN; }, {inner.name(), "box"}},
            {[](Layout& l) { l.nodes[0].bounds[0][1][0] = l.nodes[0].bounds[1][1][0]; }, {"box"}},
            {[=](Layout& l) {
                 auto& bounds = l.nodes[leaf.node].bounds;
                 bounds[0][0][leaf.child] = bounds[1][0][leaf.child];
             },
             {leaf.node_name(), "not within the leaf's box"}},
            {[=](Layout& l) { l.nodes[gap.node].bounds[0][0].back() = 0.0f; }, {gap.node_name(), no_child, "infinity"}},
            {[=](Layout& l) { l.nodes[gap.node].bounds[1][2].back() = inf; }, {gap.node_name(), no_child, "infinity"}}};
}

/// Exchanges two triangles of a block.
void exchange(TriangleBlock& block, std::size_t a, std::size_t b) {
    std::swap(block.primitives[a], block.primitives[b]);
    for (auto& corner : block.vertices) {
        for (auto& row : corner)
            std::swap(row[a], row[b]);
    }
}

template <typename Layout>
std::vector<Fault<Layout>> block_faults(const Layout& valid) {
    constexpr float inf = std::numeric_limits<float>::infinity();
    std::size_t part = 0;  // a block with less than four triangles
    while (valid.blocks[part].primitives[3] != kNone)
        ++part;
    const std::string name = "block " + std::to_string(part);
    return {{[](Layout& l) { l.blocks[5].primitives[0] = 300; }, {"primitive 300 is out of range"}},
            {[](Layout& l) { l.blocks[5].primitives[0] = l.blocks[6].primitives[0]; }, {"primitive"}},
            {[](Layout& l) { l.blocks[5].vertices[2][1][0] += 1.0f; }, {"block 5", "triangle 0", "other vertices"}},
            {[](Layout& l) { l.blocks[5].primitives.fill(kNone); }, {"block 5", "no triangle"}},
            {[=](Layout& l) { l.blocks[part].vertices[1][1][3] = 0.0f; }, {name, "triangle 3", "NaN"}},
            {[=](Layout& l) { l.blocks[part].vertices[2][2][3] = inf; }, {name, "triangle 3", "NaN"}},
            {[=](Layout& l) { l.blocks[part].primitives[3] = l.blocks[part].primitives[0]; }, {"a second time"}},
            {[=](Layout& l) { exchange(l.blocks[part], 0, 3); }, {name}}};
}

template <typename Layout>
std::vector<Fault<Layout>> whole_faults() {
    return {{[](Layout& l) { l.blocks.resize_for_overwrite(l.blocks.size() - 1); }, {"out of range"}},
            {[](Layout& l) { l.nodes.resize_for_overwrite(l.nodes.size() - 1); }, {"out of range"}},
            {[](Layout& l) { l.nodes.resize_for_overwrite(0); }, {"block 0 is not part"}},
            {[](Layout& l) { l = {}; }, {"primitive_count is 0"}},
            {[](Layout& l) {
                 l = {};
                 l.primitive_count = 300;
             },
             {"primitive 0 is in no leaf"}},
            {[](Layout& l) { l.depth += 1; }, {"depth"}},
            {[](Layout& l) { l.primitive_count = 301; }, {"primitive_count is 301", "300"}}};
}

template <typename Layout>
void check_faults(const Layout& valid, const Mesh& mesh) {
    check_faults_are_named<Layout>(valid, mesh, child_faults(valid));
    check_faults_are_named<Layout>(valid, mesh, box_faults(valid));
    check_faults_are_named<Layout>(valid, mesh, block_faults(valid));
    check_faults_are_named<Layout>(valid, mesh, whole_faults<Layout>());
}

template <typename Layout>
void cut_leaves(Layout& layout) {
    for (auto& node : layout.nodes) {
        for (std::uint32_t slot = 0; slot < node.children.size(); ++slot) {
            const std::uint32_t child = node.children[slot];
            if (child != kNone && WideChild::is_leaf(child)) node.bounds[1][0][slot] = node.bounds[0][0][slot];
        }
    }
}

template <typename Layout>
void check_lost_part_is_found(const Mesh& mesh) {
    const Layout valid = make<Layout>({"", mesh, build(mesh, "sbvh")});
    REQUIRE(valid.split_references);
    check_faults_are_named<Layout>(
        valid, mesh,
        {{[](Layout& l) { cut_leaves(l); }, {"the part of it around", "in none of the leaves"}},
         {[](Layout& l) { l.split_references = false; }, {"node", "primitive"}}});
}

}  // namespace

TEST_CASE("wide: the layout of every tree is proven, and rays hit what they hit in the tree") {
    check_layouts_of_all_scenes(make_wide8);
    check_layouts_of_all_scenes(make_wide4);
}

TEST_CASE("wide: odd trees are proven") {
    check_layouts_of_odd_trees(make_wide8);
    check_layouts_of_odd_trees(make_wide4);
    check_layout_of_deep_tree(make_wide8);
    check_layout_of_deep_tree(make_wide4);
}

TEST_CASE("wide: a fault in a layout is named") {
    // Leaves of one to four triangles, and of several blocks.
    const Mesh mesh = generate_scene("soup", 300);
    for (const std::uint32_t leaf_size : {4u, 8u}) {
        BuildOptions options;
        options.max_leaf_size = leaf_size;
        const MeshTree tree{"", mesh, build(mesh, "sweep-sah", options)};
        check_faults(make<Wide8>(tree), mesh);
        check_faults(make<Wide4>(tree), mesh);
    }
}

TEST_CASE("wide: an inactive triangle in a layout is found") {
    const Mesh mesh = generate_scene("soup", 300);
    const Wide8 layout = make<Wide8>({"", mesh, build(mesh, "sweep-sah")});
    Mesh other = mesh;
    other.vertices[other.triangles[70][1]].y = NAN;
    expect_error(ErrorCode::invalid_input, {"primitive", "inactive"}, [&] { validate(layout, other); });
}

TEST_CASE("wide: what a builder lays out is proven, with split references too") {
    const Mesh mesh = generate_scene("hair", 2000);
    for (const char* const id : {"fast", "sbvh"}) {
        if (!can_run(id)) continue;
        Wide8 layout;
        BuildOptions options;
        options.presplit_level = 14;
        Builder(id, options).build_layout(mesh, layout);
        CHECK(layout.split_references);
        CHECK_NOTHROW(validate(layout, mesh));
    }
}

TEST_CASE("wide: a layout is proven over the mesh that it was refitted to, and over no other") {
    const Mesh mesh = generate_scene("hair", 500);
    Mesh moved = mesh;
    for (Vec3& v : moved.vertices)
        v = {v.y + 0.25f * v.x, v.x - 3.0f, v.z * v.z};
    for (const char* const id : {"binned-sah", "sbvh"}) {
        Wide8 layout = make<Wide8>({"", mesh, build(mesh, id)});
        refit(layout, moved);
        CHECK_NOTHROW(validate(layout, moved));
        expect_error(ErrorCode::invalid_input, {"block", "other vertices"}, [&] {
            layout.split_references = true;
            validate(layout, mesh);
        });
    }
}

TEST_CASE("wide: a part of a split triangle that is lost is found") {
    const Mesh mesh = generate_scene("hair", 300);
    check_lost_part_is_found<Wide8>(mesh);
    check_lost_part_is_found<Wide4>(mesh);
}

TEST_CASE("wide: any bytes can be validated") {
    const Mesh mesh = generate_scene("soup", 100);
    for (const char* const id : {"sweep-sah", "sbvh"}) {
        check_any_bytes(make<Wide8>({"", mesh, build(mesh, id)}), mesh);
        check_any_bytes(make<Wide4>({"", mesh, build(mesh, id)}), mesh);
    }
}
