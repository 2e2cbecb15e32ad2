// What rebuilding the top must reach: binned SAH's tree where the top is all, the old clusters where it is not, and the
// cheaper of both tops.
#include "clbvh/optimize/rebuild_top.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <tuple>
#include <vector>

#include "clbvh/core/validate.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/sah.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

double binned_cost(const Mesh& mesh) {
    BuildOptions options;
    options.max_leaf_size = 1;
    return sah_cost(make_builder("binned-sah", options).build(mesh));
}

Bvh rebuilt(const Bvh& tree, float share, std::uint32_t passes, OptimizeStats* stats = nullptr) {
    RebuildTopConfig config;
    config.share = share;
    config.budget.passes = passes;
    return rebuild_top(tree, config, stats);
}

using Corners = std::tuple<float, float, float, float, float, float>;

/// The boxes of the inner nodes, in order.
std::vector<Corners> inner_boxes(const Bvh& tree) {
    std::vector<Corners> boxes;
    for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
        const Aabb box = tree.nodes[i].bounds();
        if (i == 1 || tree.nodes[i].is_leaf()) continue;
        boxes.emplace_back(box.lower.x, box.lower.y, box.lower.z, box.upper.x, box.upper.y, box.upper.z);
    }
    std::ranges::sort(boxes);
    return boxes;
}

std::size_t count_new(const Bvh& tree, const Bvh& old) {
    const std::vector<Corners> boxes = inner_boxes(tree), old_boxes = inner_boxes(old);
    std::vector<Corners> added;
    std::ranges::set_difference(boxes, old_boxes, std::back_inserter(added));
    return added.size();
}

}  // namespace

TEST_CASE("rebuild-top: where the top is all, the tree costs what binned SAH's does") {
    const Mesh mesh = generate_scene("clustered", 5000);
    OptimizeStats stats;
    const Bvh tree = rebuilt(built_tree("lbvh", mesh), 1.0f, 0, &stats);
    CHECK(validate(tree, mesh).error == "");
    CHECK(sah_cost(tree) == Approx(binned_cost(mesh)).epsilon(1e-9));
    CHECK(stats.passes == 1);
    CHECK(stats.changes == 1);
    CHECK(same_bytes(rebuilt(built_tree("lbvh", mesh), 0.0f, 0), rebuilt(built_tree("lbvh", mesh), 0.2f, 0)));
}

TEST_CASE("rebuild-top: what is below the top stays") {
    const Mesh mesh = generate_scene("terrain", 60000);
    const Bvh tree = built_tree("lbvh", mesh);
    std::size_t last = 0;
    double cost = sah_cost(tree);
    for (const float share : {0.03f, 0.1f, 0.3f}) {
        const Bvh better = rebuilt(tree, share, 0);
        CHECK(validate(better, mesh).error == "");
        const std::size_t added = count_new(better, tree);
        CHECK(added > last);
        CHECK(static_cast<double>(added) < 1.1 * double{share} * 60000);
        CHECK(sah_cost(better) < cost);
        last = added;
        cost = sah_cost(better);
    }
}

TEST_CASE("rebuild-top: a top that binned SAH would make dearer stays, and parts of it may still gain") {
    const Mesh mesh = generate_scene("city", 60000);
    const Bvh tree = built_tree("hploc", mesh);
    OptimizeStats stats;
    CHECK(same_bytes(rebuilt(tree, 0.03f, 1, &stats), tree));
    CHECK(stats.passes == 1);
    CHECK(stats.changes == 0);
    const Bvh better = rebuilt(tree, 0.03f, 0, &stats);
    CHECK(validate(better, mesh).error == "");
    CHECK(stats.passes == 3);
    CHECK(stats.changes > 1);
    CHECK(sah_cost(better) < sah_cost(tree));
}

TEST_CASE("rebuild-top: a share out of its range is named") {
    const Bvh tree = make_builder("median").build(generate_scene("soup", 100));
    for (const float share : {-0.1f, 1.5f, std::numeric_limits<float>::quiet_NaN()})
        expect_error(ErrorCode::invalid_input, {"share", "0 to 1"},
                     [&] { static_cast<void>(rebuilt(tree, share, 0)); });
}
