// Tests of the tests' own tools: the comparison of trees, and the trees that builders are compared with.
#include <catch2/catch.hpp>
#include <random>

#include "clbvh/core/validate.hpp"
#include "support/compare_trees.hpp"
#include "support/meshes.hpp"
#include "support/oracle/tree_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

Bvh example_tree(std::size_t count = 50) {
    return ploc_tree(morton_order(random_triangles(count), MortonCode::xyz), 4, Comparison::exact).bvh;
}

/// Moves sibling pairs to random places, and leaves' ranges too.
Bvh renumbered(const Bvh& bvh) {
    std::mt19937 random(3);
    const std::size_t pairs = bvh.nodes.size() / 2;
    std::vector<std::uint32_t> pair_place(pairs);
    for (std::uint32_t i = 0; i < pairs; ++i)
        pair_place[i] = i;
    std::shuffle(pair_place.begin() + 1, pair_place.end(), random);
    std::vector<std::uint32_t> id_place(bvh.primitive_ids.size());
    for (std::uint32_t i = 0; i < id_place.size(); ++i)
        id_place[i] = i;
    std::shuffle(id_place.begin(), id_place.end(), random);

    Bvh other = bvh;
    for (std::size_t i = 0; i < bvh.nodes.size(); ++i) {
        Node node = bvh.nodes[i];
        node.first = node.is_leaf() ? id_place[node.first] : 2 * pair_place[node.first / 2];
        other.nodes[2 * pair_place[i / 2] + i % 2] = node;
    }
    other.nodes[1] = {};
    for (std::size_t i = 0; i < id_place.size(); ++i)
        other.primitive_ids[id_place[i]] = bvh.primitive_ids[i];
    return other;
}

void expect_difference(const Bvh& a, const Bvh& b, const std::string& part) {
    CHECK_THAT(compare_trees(a, b), Catch::Contains(part));
    CHECK_FALSE(compare_trees(b, a).empty());
}

Aabb unit_box_at(float x, float y, float z) {
    return {{x, y, z}, {x + 1, y + 1, z + 1}};
}

}  // namespace

TEST_CASE("comparison: a tree equals itself under another numbering") {
    for (const std::size_t count : {0u, 1u, 2u, 3u, 50u, 3000u}) {
        const Bvh bvh = example_tree(count);
        CHECK(compare_trees(bvh, bvh).empty());
        if (count < 3) continue;
        const Bvh other = renumbered(bvh);
        CHECK(other.nodes != bvh.nodes);
        CHECK(compare_trees(bvh, other).empty());
        CHECK(validate(other, random_triangles(count)).valid);
    }
}

TEST_CASE("comparison: every kind of difference is found, with its path") {
    const Bvh bvh = example_tree();
    const std::uint32_t first = bvh.nodes[0].first;
    Bvh other = bvh;
    std::swap(other.nodes[first], other.nodes[first + 1]);
    expect_difference(bvh, other, "root/left: ");
    for (std::size_t i = 0; i < bvh.nodes.size(); ++i) {
        if (i == 1) continue;
        other = bvh;
        other.nodes[i].upper[2] = std::nextafter(other.nodes[i].upper[2], 100.0f);
        expect_difference(bvh, other, "box [");
    }
    for (std::size_t i = 0; i + 1 < bvh.primitive_ids.size(); ++i) {
        other = bvh;
        std::swap(other.primitive_ids[i], other.primitive_ids[i + 1]);
        expect_difference(bvh, other, ": primitive ");
    }
    other = bvh;
    other.nodes[first].upper[0] += 1;
    expect_difference(bvh, other, "root/left: box [");
    other = bvh;
    other.nodes[0].count = 1;
    expect_difference(bvh, other, "root: count 0 against 1");
    other = bvh;
    other.primitive_count = 51;
    expect_difference(bvh, other, "different numbers of primitives");
    expect_difference(bvh, {{}, {}, 50}, "only the second tree is empty");
}

TEST_CASE("comparison: survives references out of range and cycles") {
    const Bvh bvh = example_tree();
    Bvh other = bvh;
    other.nodes[0].first = ~0u;
    expect_difference(bvh, other, "root: children out of range");
    other = bvh;
    other.nodes[0].first = 0;
    CHECK_FALSE(compare_trees(other, other).empty());
    Bvh leaf = example_tree(1);
    leaf.primitive_ids.clear();
    expect_difference(example_tree(1), leaf, "root: primitives out of range");
}

TEST_CASE("Morton oracle: corners of a grid are ordered x before y before z") {
    const std::vector<Aabb> corners{unit_box_at(0, 0, 0), unit_box_at(0, 0, 8), unit_box_at(0, 8, 0),
                                    unit_box_at(0, 8, 8), unit_box_at(8, 0, 0), unit_box_at(8, 8, 8)};
    constexpr std::uint64_t z = 0x1249249249249249;
    CHECK(morton_codes(corners, MortonCode::xyz) ==
          std::vector<std::uint64_t>{0, z, z << 1, z << 1 | z, z << 2, z << 2 | z << 1 | z});
}

TEST_CASE("Morton oracle: each bit of the cubic code halves the axis that is longest by then") {
    // Extents 8, 2 and 1: x three times, since the first of equal axes goes first; then y, and all in turn.
    const std::vector<Aabb> corners{unit_box_at(0, 0, 0), unit_box_at(8, 0, 0), unit_box_at(0, 2, 0),
                                    unit_box_at(0, 0, 1)};
    const auto codes = morton_codes(corners, MortonCode::cubic);
    const std::string order = "xxxyxyzxyzxyz";
    for (std::size_t k = 0; k < order.size(); ++k) {
        INFO("bit " << k);
        for (std::size_t axis = 0; axis < 3; ++axis)
            CHECK((codes[1 + axis] >> (62 - k) & 1) == (order[k] == "xyz"[axis] ? 1u : 0u));
    }
}

TEST_CASE("Morton oracle: the extended code spends its bits on the longest axis, and each seventh on size") {
    // Along x alone: 31 bits of x, then the other axes' zeros; equal sizes, of a ninth of the scene's diagonal or so.
    const std::vector<Aabb> line{unit_box_at(0, 0, 0), unit_box_at(1, 0, 0), unit_box_at(7, 0, 0),
                                 unit_box_at(8, 0, 0)};
    const auto codes = morton_codes(line, MortonCode::extended);
    const auto bit = [&](std::size_t box, std::size_t k) { return codes[box] >> (62 - k) & 1; };
    // In eighths of the extent: 0, 1, 7, and all ones.
    const std::vector<std::vector<std::uint64_t>> expected{{0, 0, 0, 0}, {0, 0, 1, 0}, {1, 1, 1, 0}, {1, 1, 1, 1}};
    for (std::size_t box = 0; box < line.size(); ++box) {
        for (std::size_t k = 0; k < 4; ++k)
            CHECK(bit(box, k) == expected[box][k]);
    }
    // Each box is sqrt(3 / 83) = 0.19 of the scene's diagonal: 97 of 512 or 001100001 in binary, at k = 6, 13, 20, ...
    const std::vector<std::uint64_t> size{0, 0, 1, 1, 0, 0, 0, 0, 1};
    for (std::size_t box = 0; box < line.size(); ++box) {
        for (std::size_t s = 0; s < size.size(); ++s)
            CHECK(bit(box, 7 * s + 6) == size[s]);
    }
}

TEST_CASE("oracle trees are valid and numbered without gaps, for every algorithm and small size") {
    for (std::size_t count = 0; count <= 40; ++count) {
        const Mesh mesh = random_triangles(count);
        for (const MortonCode code : {MortonCode::cubic, MortonCode::xyz, MortonCode::extended}) {
            const MortonOrder order = morton_order(mesh, code);
            for (const Comparison comparison : {Comparison::exact, Comparison::packed}) {
                for (const std::uint32_t radius : {1u, 3u, 32u}) {
                    CHECK(validate(ploc_tree(order, radius, comparison).bvh, mesh).error.empty());
                    CHECK(validate(two_level_tree(order, radius, comparison, 7).bvh, mesh).error.empty());
                }
            }
            const Bvh lbvh = lbvh_tree(order).bvh;
            CHECK(validate(lbvh, mesh).error.empty());
            CHECK(lbvh.nodes.size() == 2 * count);
        }
    }
}

TEST_CASE("oracle: equal boxes pair up in a logarithmic number of rounds, into a shallow tree") {
    const Mesh mesh = coincident_triangles(1 << 14);
    for (const Comparison comparison : {Comparison::exact, Comparison::packed}) {
        const OracleTree tree = ploc_tree(morton_order(mesh, MortonCode::xyz), 16, comparison);
        CHECK(tree.clusters_per_iteration.size() == 14);
        CHECK(validate(tree.bvh, mesh).depth == 14);
    }
    CHECK(validate(lbvh_tree(morton_order(mesh, MortonCode::xyz)).bvh, mesh).depth == 14);
}

TEST_CASE("oracle: the nearest pairs merge first") {
    // Four boxes in a row, the middle two closest: ((0, (1, 2)), 3) by distances, with any radius that sees them.
    Mesh mesh;
    for (const float x : {0.0f, 4.0f, 5.5f, 11.0f}) {
        const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.insert(mesh.vertices.end(), {{x, 0, 0}, {x + 1, 1, 0}, {x, 0, 1}});
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    for (const std::uint32_t radius : {1u, 2u, 32u}) {
        const Bvh bvh = ploc_tree(morton_order(mesh, MortonCode::xyz), radius, Comparison::exact).bvh;
        // The pair of 1 and 2 ends position 2, that of 0 and (1, 2) position 1, the root's position 3.
        CHECK(bvh.nodes[0].first == 6);
        CHECK(bvh.nodes[6].first == 2);
        CHECK(bvh.nodes[3].first == 4);
        CHECK(bvh.nodes[7].is_leaf());
    }
}

TEST_CASE("oracle: two levels of one range are plain PLOC, and more ranges keep to Morton order") {
    const Mesh mesh = random_triangles(500);
    const MortonOrder order = morton_order(mesh, MortonCode::xyz);
    const Bvh plain = ploc_tree(order, 8, Comparison::packed).bvh;
    CHECK(compare_trees(plain, two_level_tree(order, 8, Comparison::packed, 1).bvh).empty());
    CHECK_FALSE(compare_trees(plain, two_level_tree(order, 8, Comparison::packed, 16).bvh).empty());
}
