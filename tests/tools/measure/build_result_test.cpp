#include <catch2/catch.hpp>
#include <clbvh/core/error.hpp>
#include <cmath>
#include <span>
#include <vector>

#include "measure/build_result.hpp"
#include "report/result_json.hpp"

using namespace clbvh;
using namespace clbvh::tool;

namespace {

Mesh two_triangles() {
    return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {4, 0, 0}, {5, 0, 0}, {4, 1, 0}}, {{0, 1, 2}, {3, 4, 5}}};
}

Bvh tree_of_two() {
    return {{{{0, 0, 0}, 2, {5, 1, 0}, 0}, {}, {{0, 0, 0}, 0, {1, 1, 0}, 1}, {{4, 0, 0}, 1, {5, 1, 0}, 1}}, {0, 1}, 2};
}

}  // namespace

TEST_CASE("a tree's extent is counted with and without validation") {
    for (const bool validated : {false, true}) {
        BuildResult result;
        describe_tree(result, tree_of_two(), two_triangles(), validated);
        CHECK(result.valid.has_value() == validated);
        CHECK(result.valid.value_or(true));
        CHECK(result.depth == 1);
        CHECK(result.nodes == 3);
        CHECK(result.leaves == 2);
        CHECK(result.references == 2);
        CHECK(result.primitives_per_leaf() == 1.0);
        // One root, and two leaves that each have a fifth of its area.
        CHECK(result.sah == Approx(1.2 + 2 * 0.2));
        CHECK(report_invalid_trees(std::span(&result, 1)) == 0);
    }
}

TEST_CASE("a tree that is not valid has no cost, and its own exit code") {
    Bvh bvh = tree_of_two();
    bvh.nodes[2].lower[0] = -1.0f;
    std::vector<BuildResult> results(2);
    results[1].scene = "a broken scene of this test";
    results[1].builder = "a builder";
    describe_tree(results[0], tree_of_two(), two_triangles(), true);
    describe_tree(results[1], bvh, two_triangles(), true);
    CHECK(results[1].valid == false);
    CHECK_FALSE(results[1].validation_error.empty());
    CHECK(std::isnan(results[1].sah));
    CHECK(report_invalid_trees(results) == 3);
    results[1].is_peer = true;
    CHECK(report_invalid_trees(results) == 0);
    const auto json = to_json(std::span<const BuildResult>(results));
    CHECK(json[0]["valid"] == true);
    CHECK(json[1]["valid"] == false);
    CHECK(nlohmann::ordered_json::parse(json.dump())[1]["sah"].is_null());
}

TEST_CASE("threads are counted in words, and no more of them than may run") {
    CHECK(threads_text(1) == "1 thread");
    CHECK(threads_text(2) == "2 threads");
    BuildOptions options;
    const std::uint32_t all = host_threads(options);
    options.thread_count = 1;
    CHECK(host_threads(options) == 1);
    options.thread_count = 1024;
    CHECK(host_threads(options) == all);
}
