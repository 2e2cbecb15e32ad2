// Quality that rebuilding must reach: the greedy top-down tree where the whole is built anew, and no less where only
// parts are.
#include "clbvh/optimize/rebuild.hpp"

#include <catch2/catch.hpp>

#include "clbvh/core/validate.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/sah.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

/// The cost of the greedy tree with one triangle a leaf.
double sweep_cost(const Mesh& mesh) {
    BuildOptions options;
    options.max_leaf_size = 1;
    return sah_cost(make_builder("sweep-sah", options).build(mesh));
}

}  // namespace

TEST_CASE("rebuild: a tree that fits one subtree becomes the sweep's, but for ties") {
    const Mesh mesh = generate_scene("soup", 900);
    OptimizeStats stats;
    const Bvh tree = rebuild(built_tree("lbvh", mesh), {}, &stats);
    CHECK(validate(tree, mesh).error == "");
    CHECK(sah_cost(tree) == Approx(sweep_cost(mesh)).epsilon(1e-3));
    CHECK(stats.passes == 1);
    CHECK(stats.changes == 1);
}

TEST_CASE("rebuild: the whole follows where the parts gained, and not where they did not") {
    const Mesh mesh = generate_scene("sphere", 20000);
    const Bvh clustered = built_tree("plocpp", mesh);
    OptimizeStats stats;
    CHECK(sah_cost(rebuild(clustered, {}, &stats)) == Approx(sweep_cost(mesh)).epsilon(1e-3));
    CHECK(stats.passes == 2);

    RebuildConfig reluctant;
    reluctant.whole_gain = 1.0f;
    const double in_parts = sah_cost(rebuild(clustered, reluctant, &stats));
    CHECK(stats.passes == 1);
    CHECK(stats.changes > 1);
    CHECK(in_parts < sah_cost(clustered));
    CHECK(in_parts > sweep_cost(mesh));
}

TEST_CASE("rebuild: the sweep's own tree stays as it is") {
    BuildOptions options;
    options.max_leaf_size = 1;
    const Mesh mesh = generate_scene("city", 3000);
    const Bvh tree = make_builder("sweep-sah", options).build(mesh);
    RebuildConfig whole;
    whole.subtree_leaves = 1u << 20;
    OptimizeStats stats;
    const Bvh same = rebuild(tree, whole, &stats);
    CHECK(stats.changes == 0);
    CHECK(same_bytes(same, tree));
}

TEST_CASE("rebuild: settings out of their range are named") {
    const Bvh tree = make_builder("median").build(generate_scene("soup", 100));
    RebuildConfig config;
    config.subtree_leaves = 2;
    expect_error(ErrorCode::invalid_input, {"subtree_leaves"}, [&] { static_cast<void>(rebuild(tree, config)); });
    config = {};
    config.whole_gain = 1.5f;
    expect_error(ErrorCode::invalid_input, {"whole_gain"}, [&] { static_cast<void>(rebuild(tree, config)); });
}

TEST_CASE("rebuild: a pass that is cancelled keeps what it has done, and counts it") {
    const Mesh mesh = generate_scene("sphere", 20000);
    const Bvh tree = built_tree("plocpp", mesh);
    RebuildConfig config;
    config.subtree_leaves = 32;  // hundreds of subtrees
    int left = 4;
    config.budget.progress = [&](const Progress&) { return left-- > 0; };
    OptimizeStats stats;
    const Bvh better = rebuild(tree, config, &stats);
    CHECK(stats.is_cancelled);
    CHECK(stats.passes == 0);
    CHECK(stats.changes > 0);
    CHECK(validate(better, mesh).error == "");
    CHECK(sah_cost(better) < sah_cost(tree));
}
