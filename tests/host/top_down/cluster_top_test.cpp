#include "host/top_down/cluster_top.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "clbvh/io/scene.hpp"
#include "core/exact_areas.hpp"
#include "support/builders.hpp"

using namespace clbvh;
using namespace clbvh::test;
using host::ClusterTop;

namespace {

std::size_t count_above(const Bvh& tree, float limit) {
    return static_cast<std::size_t>(std::ranges::count_if(tree.nodes, [&](const Node& node) {
        return !node.is_leaf() && node.first > 0 && half_area(node.bounds()) > limit;
    }));
}

ClusterTop top_of(const Bvh& tree, float limit) {
    ClusterTop top;
    top.gather(tree.nodes, 0, tree.nodes[0], limit);
    return top;
}

/// Checks the part of `top` at `inner` against the tree, and returns its clusters.
std::vector<Node> expect_part(const Bvh& tree, const ClusterTop& top, std::uint32_t inner) {
    const ClusterTop::Inner& part = top.inner[inner];
    const Node& node = tree.nodes[part.slot];
    CHECK(part.pair == node.first);
    CHECK(part.half_area == exact_half_area(node));
    std::vector<Node> clusters;
    std::uint32_t side = 0;
    for (const std::uint32_t child : top.children(inner)) {
        const std::uint32_t slot = node.first + side++;
        if (child == ClusterTop::kCluster) {
            clusters.push_back(tree.nodes[slot]);
            continue;
        }
        CHECK(top.inner[child].slot == slot);
        const std::vector<Node> below = expect_part(tree, top, child);
        clusters.insert(clusters.end(), below.begin(), below.end());
    }
    CHECK(part.cluster_count == clusters.size());
    CHECK(std::ranges::equal(clusters, std::span(top.clusters).subspan(part.first_cluster, part.cluster_count)));
    return clusters;
}

}  // namespace

TEST_CASE("cluster top: the limit leaves the share that was asked for, but not less than a thousand nodes") {
    for (const std::uint32_t count : {2u, 3u, 500u}) {
        const Bvh tree = built_tree("lbvh", generate_scene("soup", count));
        CHECK(count_above(tree, host::area_limit(tree.nodes, 0.0)) == count - 1);
    }
    const Bvh small = built_tree("lbvh", generate_scene("soup", 4001));  // every node is a sample
    CHECK(count_above(small, host::area_limit(small.nodes, 0.0)) == 1024);
    CHECK(count_above(small, host::area_limit(small.nodes, 0.5)) == 2000);
    CHECK(count_above(small, host::area_limit(small.nodes, 1.0)) == 4000);
    const Bvh large = built_tree("lbvh", generate_scene("clustered", 200000));
    for (const double share : {0.01, 0.03, 0.3})
        CHECK(static_cast<double>(count_above(large, host::area_limit(large.nodes, share))) ==
              Approx(share * 200000).epsilon(0.2));
}

TEST_CASE("cluster top: gathers the nodes above the limit and what is below them, left to right") {
    const Bvh tree = built_tree("lbvh", generate_scene("city", 3000));
    for (const double share : {0.35, 0.6, 1.0}) {
        const float limit = host::area_limit(tree.nodes, share);
        const ClusterTop top = top_of(tree, limit);
        REQUIRE(top.inner.size() == count_above(tree, limit));
        REQUIRE(top.clusters.size() == top.inner.size() + 1);
        expect_part(tree, top, 0);
    }
    const ClusterTop none = top_of(tree, half_area(tree.nodes[0].bounds()));
    CHECK(none.inner.empty());
    CHECK(none.clusters == std::vector<Node>{tree.nodes[0]});
}

TEST_CASE("cluster top: a part that is built anew keeps its clusters and leaves the rest of the tree alone") {
    Bvh tree = built_tree("lbvh", generate_scene("city", 3000));
    const Bvh before = tree;
    const ClusterTop top = top_of(tree, host::area_limit(tree.nodes, 1.0));
    const auto [left, right] = top.children(0);
    REQUIRE(left != ClusterTop::kCluster);
    REQUIRE(right != ClusterTop::kCluster);
    host::TopWorkspace workspace;
    const double gain = host::rebuild_top(tree.nodes, top, right, host::build_by_sweep, workspace);
    REQUIRE(gain > 0.0);
    const ClusterTop after = top_of(tree, -1.0f);
    CHECK(after.inner.size() == top.inner.size());
    CHECK(after.children(0) == top.children(0));
    double old_area = 0.0, area = 0.0;
    for (std::uint32_t i = 0; i < top.inner.size(); ++i) {
        old_area += top.inner[i].half_area;
        area += after.inner[i].half_area;
        if (i < right) CHECK(tree.nodes[top.inner[i].slot] == before.nodes[top.inner[i].slot]);
    }
    CHECK(area == Approx(old_area - gain).epsilon(1e-9));
    CHECK(host::rebuild_top(tree.nodes, after, right, host::build_by_sweep, workspace) == 0.0);
}
