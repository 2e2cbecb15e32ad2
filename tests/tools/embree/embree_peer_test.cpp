#include <algorithm>
#include <catch2/catch.hpp>
#include <clbvh/builder.hpp>
#include <clbvh/core/error.hpp>
#include <clbvh/core/validate.hpp>
#include <clbvh/io/scene.hpp>
#include <clbvh/metrics/sah.hpp>
#include <clbvh/metrics/tree_statistics.hpp>
#include <limits>

#include "embree/embree_error.hpp"
#include "embree/embree_peer.hpp"

using namespace clbvh;
using namespace clbvh::tool;

namespace {

/// A scene without every seventh triangle: a NaN takes it out.
Mesh with_inactive(Mesh mesh) {
    const auto nan = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back({0.0f, std::numeric_limits<float>::quiet_NaN(), 0.0f});
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 7)
        mesh.triangles[i][1] = nan;
    return mesh;
}

Mesh equal_triangles(std::size_t count) {
    return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, std::vector<Triangle>(count, Triangle{0, 1, 2})};
}

std::uint32_t largest_leaf(const Bvh& bvh) {
    return std::ranges::max(bvh.nodes, {}, &Node::count).count;
}

}  // namespace

TEST_CASE("the trees of Embree's builders are valid, whatever the mesh and the options") {
    std::vector<Mesh> meshes{equal_triangles(0), equal_triangles(1), equal_triangles(2), equal_triangles(20000)};
    for (const char* scene : {"gen:soup:3000", "gen:hair:3000", "gen:line:2000", "gen:terrain:20000"})
        meshes.push_back(load_scene(scene));
    meshes.push_back(with_inactive(load_scene("gen:city:3000")));
    for (const Mesh& mesh : meshes) {
        for (const std::uint32_t max_leaf : {0u, 1u, 32u}) {
            BuildOptions options;
            options.max_leaf_size = max_leaf;
            options.thread_count = 2;
            for (const auto& peer : make_embree_peers(options, mesh)) {
                INFO(peer->name() << " over " << mesh.triangles.size() << " triangles, leaves of " << max_leaf);
                peer->run(false);
                peer->run(true);
                const BuildResult result = peer->result();
                CHECK(result.builder == peer->name());
                CHECK(result.is_peer);
                CHECK(result.threads == host_threads(options));
                CHECK(result.build_ms.min > 0.0);
                CHECK(result.inactive_primitives == check_mesh(mesh));
                if (!peer->tree()) {
                    CHECK(peer->name() == "embree-commit-low");
                    continue;
                }
                const Bvh bvh = *peer->tree();
                const ValidationReport report = validate(bvh, mesh);
                INFO(report.error);
                CHECK(report.valid);
                CHECK(bvh.split_references == (peer->name() == "embree-sbvh"));
                if (!bvh.empty()) CHECK(largest_leaf(bvh) <= (max_leaf == 0 ? 8 : max_leaf));
            }
        }
    }
}

TEST_CASE("Embree's trees are worth what such trees are worth") {
    const Mesh mesh = load_scene("gen:hair:20000");
    BuildOptions options;
    options.sbvh.reference_budget = 1.5f;
    const auto peers = make_embree_peers(options, mesh);
    std::vector<Bvh> trees;
    for (const auto& peer : peers) {
        peer->run(true);
        if (const auto tree = peer->tree()) trees.push_back(*tree);
    }
    const double morton = sah_cost(trees.at(0));
    const double binned = sah_cost(trees.at(1));
    const double sbvh = sah_cost(trees.at(2));
    CHECK(binned == Approx(sah_cost(build(mesh, "binned-sah"))).epsilon(0.05));
    CHECK(morton > binned);
    CHECK(sbvh < binned);
    CHECK(tree_statistics(trees[0]).leaves == 20000);
    CHECK(trees[2].primitive_ids.size() > 20000);
    CHECK(trees[2].primitive_ids.size() <= 30000);
}

TEST_CASE("a scene is committed anew in every run, with memory that stays") {
    const Mesh mesh = load_scene("gen:city:20000");
    const auto peers = make_embree_peers({}, mesh);
    TreeContestant& commit = *peers.back();
    REQUIRE(commit.name() == "embree-commit-low");
    commit.run(true);
    const std::uint64_t once = commit.result().peak_bytes;
    // A commit that built nothing would take microseconds; boxes, codes and a tree of so many triangles do not.
    CHECK(commit.result().build_ms.min > 0.05);
    for (int run = 0; run < 4; ++run)
        commit.run(true);
    CHECK(commit.result().build_ms.min > 0.05);
    CHECK(once > mesh.triangles.size() * 32);
    CHECK(commit.result().peak_bytes < 2 * once);
}

TEST_CASE("Embree's limit on the size of leaves is told before any work") {
    BuildOptions options;
    options.max_leaf_size = 33;
    CHECK_THROWS_AS(check_embree_peers(options), Error);
    options.max_leaf_size = 32;
    CHECK_NOTHROW(check_embree_peers(options));
}

TEST_CASE("Embree's errors have their names") {
    CHECK(embree_error_name(RTC_ERROR_INVALID_ARGUMENT) == "RTC_ERROR_INVALID_ARGUMENT");
    CHECK(embree_error_name(RTC_ERROR_OUT_OF_MEMORY) == "RTC_ERROR_OUT_OF_MEMORY");
}
