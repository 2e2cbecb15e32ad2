#include "clbvh/core/validate.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "support/meshes.hpp"
#include "support/oracle/tree_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct Tree {
    Mesh mesh;
    Bvh bvh;
};

Bvh build_tree(const Mesh& mesh) {
    return ploc_tree(morton_order(mesh, MortonCode::xyz), 8, Comparison::exact).bvh;
}

Tree random_tree(std::size_t count) {
    Tree tree;
    tree.mesh = random_triangles(count);
    tree.bvh = build_tree(tree.mesh);
    return tree;
}

void set_box(Node& node, const Aabb& box) {
    node = {{box.lower.x, box.lower.y, box.lower.z}, node.first, {box.upper.x, box.upper.y, box.upper.z}, node.count};
}

/// The first node from the root, breadth first and left to right, for which `wanted` holds, but not the root.
template <typename Predicate>
std::uint32_t find_node(const Bvh& bvh, Predicate wanted) {
    std::vector<std::uint32_t> queue{0};
    for (std::size_t i = 0; i < queue.size(); ++i) {
        const Node& node = bvh.nodes[queue[i]];
        if (i > 0 && wanted(node)) return queue[i];
        if (node.is_leaf()) continue;
        queue.push_back(node.first);
        queue.push_back(node.first + 1);
    }
    throw std::logic_error("no such node");
}

std::uint32_t find_leaf(const Bvh& bvh) {
    return find_node(bvh, [](const Node& node) { return node.is_leaf(); });
}

std::uint32_t find_inner(const Bvh& bvh) {
    return find_node(bvh, [](const Node& node) { return !node.is_leaf(); });
}

void expect_invalid(const Tree& tree, const std::string& part) {
    const ValidationReport report = validate(tree.bvh, tree.mesh);
    CHECK_FALSE(report.valid);
    CHECK_FALSE(report);
    CHECK_THAT(report.error, Catch::Contains(part));
}

/// Two triangles in one leaf beside a leaf of one, by hand.
Tree tree_with_larger_leaf() {
    Tree tree;
    tree.mesh = random_triangles(3);
    tree.bvh.primitive_count = 3;
    tree.bvh.primitive_ids = {2, 0, 1};
    tree.bvh.nodes.resize(4);
    const Aabb left = merge(triangle_bounds(tree.mesh, 2), triangle_bounds(tree.mesh, 0));
    const Aabb right = triangle_bounds(tree.mesh, 1);
    tree.bvh.nodes[2] = {{}, 0, {}, 2};
    tree.bvh.nodes[3] = {{}, 2, {}, 1};
    tree.bvh.nodes[0] = {{}, 2, {}, 0};
    set_box(tree.bvh.nodes[2], left);
    set_box(tree.bvh.nodes[3], right);
    set_box(tree.bvh.nodes[0], merge(left, right));
    return tree;
}

/// A triangle across a square, as two leaves of a split at x = 0.5 see it.
Tree split_tree() {
    Tree tree;
    tree.mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    tree.mesh.triangles = {{0, 1, 2}};
    tree.bvh.nodes = {
        {{0, 0, 0}, 2, {1, 1, 0}, 0}, {}, {{0, 0, 0}, 0, {0.5f, 1, 0}, 1}, {{0.5f, 0, 0}, 1, {1, 0.5f, 0}, 1}};
    tree.bvh.primitive_ids = {0, 0};
    tree.bvh.primitive_count = 1;
    tree.bvh.split_references = true;
    return tree;
}

}  // namespace

TEST_CASE("sound trees of every small size are valid") {
    for (std::size_t count = 0; count <= 70; ++count) {
        const Tree tree = random_tree(count);
        const ValidationReport report = validate(tree.bvh, tree.mesh);
        INFO(count << ": " << report.error);
        CHECK(report.valid);
        CHECK(report.error.empty());
        CHECK(report.leaves == count);
        CHECK(report.nodes == (count == 0 ? 0 : 2 * count - 1));
        CHECK(report.depth >= (count == 0 ? 0 : std::bit_width(count - 1)));
        CHECK(report.depth <= (count == 0 ? 0 : count - 1));
    }
}

TEST_CASE("a large tree is valid, and depth is the longest path") {
    Tree tree = random_tree(30000);
    CHECK(validate(tree.bvh, tree.mesh).error.empty());
}

TEST_CASE("depth is counted in edges") {
    CHECK(validate(random_tree(1).bvh, random_triangles(1)).depth == 0);
    CHECK(validate(random_tree(2).bvh, random_triangles(2)).depth == 1);
    CHECK(validate(random_tree(3).bvh, random_triangles(3)).depth == 2);
}

TEST_CASE("a chain as deep as a tree can be is walked without recursion") {
    constexpr std::uint32_t count = 300000;
    Tree tree;
    tree.mesh = coincident_triangles(count);
    tree.bvh.primitive_count = count;
    tree.bvh.nodes.resize(2 * count);
    const Aabb box = triangle_bounds(tree.mesh, 0);
    for (std::uint32_t i = 0; i < count; ++i) {
        tree.bvh.primitive_ids.push_back(i);
        const bool last = i == count - 1;
        const std::uint32_t inner = i == 0 ? 0 : 2 * i + 1;
        tree.bvh.nodes[inner] = {{}, last ? i : 2 * (i + 1), {}, last ? 1u : 0u};
        set_box(tree.bvh.nodes[inner], box);
        if (last) continue;
        tree.bvh.nodes[2 * (i + 1)] = {{}, i, {}, 1};
        set_box(tree.bvh.nodes[2 * (i + 1)], box);
    }
    const ValidationReport report = validate(tree.bvh, tree.mesh);
    INFO(report.error);
    CHECK(report.valid);
    CHECK(report.depth == count - 1);
}

TEST_CASE("leaves may hold several primitives, and slots may be unused") {
    Tree tree = tree_with_larger_leaf();
    CHECK(validate(tree.bvh, tree.mesh).valid);
    CHECK(validate(tree.bvh, tree.mesh).leaves == 2);
    tree.bvh.nodes.resize(8, Node{{1, 2, 3}, 4, {5, 6, 7}, 8});
    CHECK(validate(tree.bvh, tree.mesh).valid);
    tree.bvh.nodes[0].first = 6;
    std::swap(tree.bvh.nodes[2], tree.bvh.nodes[6]);
    std::swap(tree.bvh.nodes[3], tree.bvh.nodes[7]);
    CHECK(validate(tree.bvh, tree.mesh).valid);
    tree.bvh.nodes[6].count = 1;
    expect_invalid(tree, "node 6: its box is not the union of its primitives");
}

TEST_CASE("an empty tree is valid only where no primitive is active") {
    Tree tree;
    CHECK(validate(tree.bvh, tree.mesh).valid);
    tree.mesh = random_triangles(3);
    tree.bvh.primitive_count = 3;
    expect_invalid(tree, "primitive 0 is in no leaf");
    deactivate_triangles(tree.mesh, 0, 2);
    expect_invalid(tree, "primitive 1 is in no leaf");
    deactivate_triangles(tree.mesh);
    CHECK(validate(tree.bvh, tree.mesh).valid);
}

TEST_CASE("inactive primitives must be left out") {
    Tree tree = random_tree(50);
    deactivate_triangles(tree.mesh, 3, 100);
    expect_invalid(tree, "primitive 3 is inactive");
    tree.bvh = build_tree(tree.mesh);
    CHECK(validate(tree.bvh, tree.mesh).valid);
    CHECK(validate(tree.bvh, tree.mesh).leaves == 49);
}

TEST_CASE("boxes that differ from the union by one unit in the last place are found in every node") {
    const Tree sound = random_tree(40);
    for (std::size_t i = 0; i < sound.bvh.nodes.size(); ++i) {
        if (i == 1) continue;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (const float towards : {-kInfinity, kInfinity}) {
                Tree tree = sound;
                float& lower = tree.bvh.nodes[i].lower[axis];
                lower = std::nextafter(lower, towards);
                expect_invalid(tree, "its box is not the union of its ");
                tree = sound;
                float& upper = tree.bvh.nodes[i].upper[axis];
                upper = std::nextafter(upper, towards);
                expect_invalid(tree, "its box is not the union of its ");
            }
        }
    }
}

TEST_CASE("boxes that are NaN are found, in a child as in the root") {
    for (const std::size_t node : {0u, 2u, 3u}) {
        Tree tree = random_tree(20);
        tree.bvh.nodes[node].upper[1] = kNan;
        expect_invalid(tree, "its box is not the union of its ");
    }
}

TEST_CASE("negative and positive zero are the same in a box") {
    Tree tree;
    tree.mesh.vertices = {{-0.0f, 0.0f, 1.0f}, {2.0f, -0.0f, -0.0f}, {0.0f, 0.0f, 0.0f}};
    tree.mesh.triangles = {{0, 1, 2}};
    tree.bvh = {{{{0.0f, -0.0f, 0.0f}, 0, {2.0f, 0.0f, 1.0f}, 1}, {}}, {0}, 1};
    CHECK(validate(tree.bvh, tree.mesh).valid);
    tree.bvh.nodes[0].lower[0] = -0.0f;
    tree.bvh.nodes[0].upper[1] = -0.0f;
    CHECK(validate(tree.bvh, tree.mesh).valid);
}

TEST_CASE("a swapped child is found by the boxes") {
    Tree tree = random_tree(60);
    const std::uint32_t a = find_inner(tree.bvh);
    const std::uint32_t b = find_node(tree.bvh, [&](const Node& node) {
        return !node.is_leaf() && node.first != tree.bvh.nodes[a].first && node.bounds() != tree.bvh.nodes[a].bounds();
    });
    std::swap(tree.bvh.nodes[tree.bvh.nodes[a].first], tree.bvh.nodes[tree.bvh.nodes[b].first]);
    expect_invalid(tree, "its box is not the union of its children");
}

TEST_CASE("swapped siblings are still a correct tree") {
    Tree tree = random_tree(60);
    const std::uint32_t first = tree.bvh.nodes[0].first;
    std::swap(tree.bvh.nodes[first], tree.bvh.nodes[first + 1]);
    CHECK(validate(tree.bvh, tree.mesh).valid);
}

TEST_CASE("a primitive that is missing or there twice is found") {
    Tree tree = random_tree(60);
    tree.mesh = coincident_triangles(60);
    tree.bvh = build_tree(tree.mesh);
    REQUIRE(validate(tree.bvh, tree.mesh).valid);

    Tree twice = tree;
    twice.bvh.primitive_ids[7] = twice.bvh.primitive_ids[30];
    expect_invalid(twice, "is in the tree a second time");

    Tree missing = tree;
    const std::uint32_t leaf = find_leaf(missing.bvh);
    const std::uint32_t pair = leaf & ~1u;
    const std::uint32_t lost = missing.bvh.primitive_ids[missing.bvh.nodes[leaf].first];
    REQUIRE(missing.bvh.nodes[pair ^ 1u].is_leaf());
    const std::uint32_t parent =
        find_node(missing.bvh, [&](const Node& node) { return !node.is_leaf() && node.first == pair; });
    missing.bvh.nodes[parent] = missing.bvh.nodes[leaf ^ 1u];
    expect_invalid(missing, "primitive " + std::to_string(lost) + " is in no leaf");
}

TEST_CASE("overlapping leaves are found") {
    Tree tree = tree_with_larger_leaf();
    tree.bvh.nodes[3].first = 1;
    expect_invalid(tree, "node 3: primitive 0 is in the tree a second time");
}

TEST_CASE("references out of range are found") {
    const Tree sound = random_tree(60);
    Tree tree = sound;
    tree.bvh.nodes[0].first = 120;
    expect_invalid(tree, "node 0: its children 120 and 121 are out of range (there are 120 nodes)");
    tree.bvh.nodes[0].first = 0xfffffffe;
    expect_invalid(tree, "node 0: its children 4294967294 and 4294967295 are out of range");

    const std::uint32_t leaf = find_leaf(sound.bvh);
    tree = sound;
    tree.bvh.nodes[leaf].first = 60;
    expect_invalid(tree, "its primitive range ends at 61, but there are 60 primitive ids");
    tree.bvh.nodes[leaf] = {{}, ~0u, {}, ~0u};
    expect_invalid(tree, "its primitive range ends at 8589934590");
    tree = sound;
    tree.bvh.primitive_ids[11] = 60;
    expect_invalid(tree, "primitive 60 is out of range (the mesh has 60 triangles)");
    tree = sound;
    tree.bvh.primitive_ids.clear();
    expect_invalid(tree, "but there are 0 primitive ids");
}

TEST_CASE("children that start at an odd index are found") {
    Tree tree = random_tree(60);
    const std::uint32_t inner = find_inner(tree.bvh);
    tree.bvh.nodes[inner].first |= 1u;
    expect_invalid(tree, "node " + std::to_string(inner) + ": its children");
    expect_invalid(tree, "start at an odd index");
}

TEST_CASE("cycles and shared children are found") {
    const Tree sound = random_tree(60);
    const std::uint32_t inner = find_inner(sound.bvh);
    Tree tree = sound;
    tree.bvh.nodes[inner].first = 0;
    expect_invalid(tree, "node " + std::to_string(inner) + ": its children 0 and 1 have another parent");
    tree = sound;
    tree.bvh.nodes[inner].first = inner & ~1u;
    expect_invalid(tree, "have another parent");
    tree = sound;
    tree.bvh.nodes[0].first = 0;
    expect_invalid(tree, "node 0: its children 0 and 1 have another parent, or are the root");
    tree = sound;
    tree.bvh.nodes[find_leaf(tree.bvh)] = tree.bvh.nodes[inner];
    expect_invalid(tree, "have another parent");
}

TEST_CASE("node 1 must be there and zero") {
    Tree tree = random_tree(1);
    tree.bvh.nodes[1].first = 1;
    expect_invalid(tree, "node 1 is not zero");
    tree.bvh.nodes[1] = {{0, 0, 1e-30f}, 0, {}, 0};
    expect_invalid(tree, "node 1 is not zero");
    tree.bvh.nodes.resize(1);
    expect_invalid(tree, "node 1, the unused zero beside the root, is missing");
}

TEST_CASE("a tree over another number of primitives is found") {
    Tree tree = random_tree(60);
    tree.bvh.primitive_count = 61;
    expect_invalid(tree, "primitive_count is 61, but the mesh has 60 triangles");
}

TEST_CASE("a tree cannot be valid over a mesh that is not") {
    Tree tree = random_tree(60);
    tree.mesh.triangles[9][1] = 1000;
    expect_invalid(tree, "the mesh is not valid: triangle 9: vertex index 1000 is out of range");
}

TEST_CASE("validation survives trees of random bytes") {
    std::mt19937 random(7);
    const auto below = [&](std::size_t limit) { return static_cast<std::uint32_t>(random() % limit); };
    const Mesh mesh = random_triangles(64);
    for (int round = 0; round < 2000; ++round) {
        Bvh bvh;
        bvh.primitive_count = 64;
        bvh.split_references = round % 2 == 1;
        bvh.nodes.resize(2 + below(200));
        for (std::size_t i = 0; i < bvh.nodes.size(); ++i) {
            if (i == 1) continue;
            const std::uint32_t reference = below(bvh.nodes.size() + 8);
            const bool leaf = below(4) == 0;
            bvh.nodes[i] = {{}, leaf ? reference : reference & ~1u, {}, leaf ? 1 + below(3) : 0};
        }
        bvh.primitive_ids.resize(below(200));
        for (std::uint32_t& id : bvh.primitive_ids)
            id = below(66);
        if (validate(bvh, mesh).valid) FAIL("round " << round);
    }
}

TEST_CASE("split references: a primitive may be in several leaves, which cover it together") {
    Tree tree = split_tree();
    CHECK(validate(tree.bvh, tree.mesh).error.empty());
    CHECK(validate(tree.bvh, tree.mesh).leaves == 2);
    tree.bvh.split_references = false;
    expect_invalid(tree, "node 3: primitive 0 is in the tree a second time");
}

TEST_CASE("split references: a tree that has none is valid as such") {
    Tree tree = random_tree(200);
    tree.bvh.split_references = true;
    CHECK(validate(tree.bvh, tree.mesh).error.empty());
    tree = {};
    tree.bvh.split_references = true;
    CHECK(validate(tree.bvh, tree.mesh).valid);
}

TEST_CASE("split references: a lost part is found, also one of a few units in the last place") {
    for (const float gap : {0.25f, 1e-3f, 1e-6f}) {
        Tree tree = split_tree();
        tree.bvh.nodes[3].lower[0] += gap;
        expect_invalid(tree, gap > 0.1f ? "primitive 0: the part of it around (0.625, 0.1875, 0)"
                                        : "primitive 0: the part of it around (0.5");
        expect_invalid(tree, "is in none of the leaves that name it");
    }
    Tree tree = split_tree();
    tree.bvh.nodes[3].upper[1] = 0.49f;
    expect_invalid(tree, "primitive 0: the part of it around (0.50");
    tree = split_tree();
    tree.bvh.nodes[3] = tree.bvh.nodes[2];
    tree.bvh.nodes[3].first = 1;
    tree.bvh.nodes[0].upper[0] = 0.5f;
    expect_invalid(tree, "primitive 0: the part of it around (0.6");
}

TEST_CASE("split references: the first primitive that is lost is named") {
    Tree tree = random_tree(300);
    tree.bvh.split_references = true;
    std::vector<std::uint32_t> leaf_of(300);
    for (std::uint32_t node = 0; node < tree.bvh.nodes.size(); ++node) {
        if (tree.bvh.nodes[node].is_leaf()) leaf_of[tree.bvh.primitive_ids[tree.bvh.nodes[node].first]] = node;
    }
    for (const std::uint32_t primitive : {250u, 77u, 130u}) {
        // The leaf shrinks to a corner of its triangle; all boxes above it stay unions of their children.
        Node& leaf = tree.bvh.nodes[leaf_of[primitive]];
        const Vec3 corner = tree.mesh.vertices[tree.mesh.triangles[primitive][0]];
        set_box(leaf, {corner, corner});
    }
    const auto refit = [&](const auto& self, std::uint32_t index) -> Aabb {
        Node& node = tree.bvh.nodes[index];
        if (!node.is_leaf()) set_box(node, merge(self(self, node.first), self(self, node.first + 1)));
        return node.bounds();
    };
    refit(refit, 0);
    expect_invalid(tree, "primitive 77: the part of it around (");
}

TEST_CASE("split references: boxes must lie within the union of the primitives, and inner ones be unions") {
    for (const std::size_t node : {2u, 3u}) {
        Tree tree = split_tree();
        tree.bvh.nodes[node].upper[2] = 1e-30f;
        expect_invalid(tree, "node 0: its box is not the union of its children");
        tree.bvh.nodes[0].upper[2] = 1e-30f;
        expect_invalid(tree, "its box is not within the union of its primitives");
        tree = split_tree();
        tree.bvh.nodes[node].upper[1] = kNan;
        expect_invalid(tree, "its box is not ");
        tree = split_tree();
        std::swap(tree.bvh.nodes[node].lower[0], tree.bvh.nodes[node].upper[0]);
        expect_invalid(tree, "its box is not ");
    }
}

TEST_CASE("split references: a leaf names a primitive once, and shares no ids with another") {
    Tree tree = split_tree();
    tree.bvh.nodes[2].count = 2;
    expect_invalid(tree, "node 2: primitive 0 is in this leaf a second time");
    tree = split_tree();
    tree.bvh.nodes[3].first = 0;
    expect_invalid(tree, "node 3: primitive id 0 belongs to another leaf");
    tree = split_tree();
    tree.mesh.triangles.push_back({0, 1, 2});
    tree.bvh.primitive_count = 2;
    expect_invalid(tree, "primitive 1 is in no leaf");
    deactivate_triangles(tree.mesh);
    expect_invalid(tree, "primitive 0 is inactive");
}
