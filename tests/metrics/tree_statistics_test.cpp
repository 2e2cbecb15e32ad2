#include "clbvh/metrics/tree_statistics.hpp"

#include <catch2/catch.hpp>
#include <numeric>

#include "clbvh/builder.hpp"
#include "clbvh/core/validate.hpp"
#include "clbvh/io/scene.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

using Counts = std::vector<std::uint64_t>;

/// A box of 4 x 1 x 1, half its area 9, over [0, 3] and [2, 4], which share 1 x 1 x 1 (3). The first is [0, 1.5] and
/// [1.5, 3], which share a face of 1.
Bvh hand_made_tree() {
    Bvh bvh;
    bvh.nodes = {{{0, 0, 0}, 2, {4, 1, 1}, 0},   {},
                 {{0, 0, 0}, 4, {3, 1, 1}, 0},   {{2, 0, 0}, 0, {4, 1, 1}, 3},
                 {{0, 0, 0}, 3, {1.5, 1, 1}, 1}, {{1.5, 0, 0}, 4, {3, 1, 1}, 1}};
    bvh.primitive_ids = {0, 1, 2, 3, 4};
    bvh.primitive_count = 5;
    return bvh;
}

}  // namespace

TEST_CASE("the shape of a tree made by hand") {
    const TreeStatistics statistics = tree_statistics(hand_made_tree());
    CHECK(statistics.nodes == 5);
    CHECK(statistics.leaves == 3);
    CHECK(statistics.references == 5);
    CHECK(statistics.leaves_by_depth == Counts{0, 1, 2});
    CHECK(statistics.leaves_by_size == Counts{0, 2, 0, 1});
    CHECK(statistics.depth() == 2);
    CHECK(statistics.mean_leaf_depth() == Approx(5.0 / 3));
    CHECK(statistics.sibling_overlap == Approx((3.0 + 1.0) / 9.0).epsilon(1e-14));

    Bvh apart = hand_made_tree();
    apart.nodes[3].lower[0] = 3.5f;
    apart.nodes[5].lower[0] = 2.0f;
    CHECK(tree_statistics(apart).sibling_overlap == 0.0);
    for (Node& node : apart.nodes)
        node = {{}, node.first, {}, node.count};
    CHECK(tree_statistics(apart).sibling_overlap == 0.0);
}

TEST_CASE("the empty tree and the single leaf have a shape too") {
    const TreeStatistics none = tree_statistics({});
    CHECK(none.nodes == 0);
    CHECK(none.depth() == 0);
    CHECK(none.mean_leaf_depth() == 0.0);
    CHECK(none.leaves_by_depth.empty());
    Bvh single;
    single.nodes = {{{0, 0, 0}, 0, {1, 1, 1}, 2}, {}};
    single.primitive_ids = {0, 1};
    const TreeStatistics one = tree_statistics(single);
    CHECK(one.nodes == 1);
    CHECK(one.depth() == 0);
    CHECK(one.leaves_by_depth == Counts{1});
    CHECK(one.leaves_by_size == Counts{0, 0, 1});
    CHECK(one.sibling_overlap == 0.0);
}

TEST_CASE("a tree's shape agrees with validation, and histograms with their totals") {
    const Mesh mesh = generate_scene("clustered", 5000);
    for (const char* id : {"median", "sbvh", "locally-ordered", "aac-hq"}) {
        const Bvh bvh = Builder(id).build(mesh);
        const TreeStatistics statistics = tree_statistics(bvh);
        const ValidationReport report = validate(bvh, mesh);
        CHECK(statistics.nodes == report.nodes);
        CHECK(statistics.leaves == report.leaves);
        CHECK(statistics.depth() == report.depth);
        const auto total = [](const Counts& counts) { return std::accumulate(counts.begin(), counts.end(), 0ULL); };
        CHECK(total(statistics.leaves_by_depth) == statistics.leaves);
        CHECK(total(statistics.leaves_by_size) == statistics.leaves);
        std::uint64_t references = 0;
        for (std::size_t size = 0; size < statistics.leaves_by_size.size(); ++size)
            references += size * statistics.leaves_by_size[size];
        CHECK(references == statistics.references);
        CHECK(references == bvh.primitive_ids.size());
        CHECK(statistics.sibling_overlap > 0.0);
    }
}

TEST_CASE("describing a tree ends though the nodes are none") {
    const auto refused = [](const std::string& part, const auto& spoil) {
        Bvh bvh = hand_made_tree();
        spoil(bvh);
        expect_error(ErrorCode::invalid_input, {part}, [&] { (void)tree_statistics(bvh); });
    };
    refused("node 4: its children 0 and 1 have another parent", [](Bvh& bvh) { bvh.nodes[4] = {{}, 0, {}, 0}; });
    refused("node 0: its children 6 and 7 are out of range", [](Bvh& bvh) { bvh.nodes[0].first = 6; });
    refused("node 2: its children 4294967294", [](Bvh& bvh) { bvh.nodes[2].first = 0xFFFFFFFEU; });
    refused("node 3: its primitive range ends at 4294967295", [](Bvh& bvh) { bvh.nodes[3].count = 0xFFFFFFFFU; });
}
