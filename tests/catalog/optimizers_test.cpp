// What every optimiser of the table keeps: a valid tree over the same leaves, no dearer than before, the same bytes on
// any number of threads, within its budget, whatever the tree.
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "clbvh/catalog.hpp"
#include "clbvh/core/validate.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/sah.hpp"
#include "clbvh/optimize/rotate.hpp"
#include "support/box_sets.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"
#include "support/hard_trees.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

/// Annealing in full would take minutes; a few passes meet the same code.
OptimizeBudget short_budget() {
    OptimizeBudget budget;
    budget.passes = 60;
    return budget;
}

/// Those that take a finished tree.
std::vector<OptimizerInfo> tree_optimizers() {
    std::vector<OptimizerInfo> list(optimizers().begin(), optimizers().end());
    std::erase_if(list, [](const OptimizerInfo& info) { return info.splits_first; });
    return list;
}

bool is_no_dearer(double cost, double than) {
    return cost <= than * (1.0 + 1e-12);
}

/// False after the first failed check.
bool expect_improved(std::string_view id, const Bvh& tree, const Mesh& mesh, const std::string& where) {
    INFO(id << " on " << where);
    OptimizeStats stats;
    const Bvh better = optimize(tree, id, short_budget(), &stats);
    const ValidationReport report = validate(better, mesh);
    CHECK(report.error == "");
    CHECK(is_no_dearer(sah_cost(better), sah_cost(tree)));
    CHECK(stats.passes <= 60);
    CHECK_FALSE(stats.is_cancelled);
    const bool same_leaves = leaves_of(better) == leaves_of(tree);
    CHECK(same_leaves);
    return report.valid && same_leaves && is_no_dearer(sah_cost(better), sah_cost(tree));
}

Bvh on_threads(int count, std::string_view id, const Bvh& tree) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(count));
    tbb::task_arena arena(count);
    return arena.execute([&] { return optimize(tree, id, short_budget()); });
}

}  // namespace

TEST_CASE("optimizers: every one improves the tree of every builder, on every generated scene") {
    for (const SceneGeneratorInfo& scene : scene_generators()) {
        const Mesh mesh = generate_scene(scene.name, 1500);
        for (const BuilderInfo& builder : builders()) {
            const Bvh tree = built_tree(builder.id, mesh);
            for (const OptimizerInfo& optimizer : tree_optimizers()) {
                const std::string where = std::string(builder.id) + ", " + std::string(scene.name);
                if (!expect_improved(optimizer.id, tree, mesh, where)) return;
            }
        }
    }
}

TEST_CASE("optimizers: trees of a Morton order become much better") {
    const Mesh mesh = generate_scene("clustered", 20000);
    const Bvh tree = built_tree("lbvh", mesh);
    for (const OptimizerInfo& optimizer : tree_optimizers()) {
        INFO(optimizer.id);
        CHECK(sah_cost(optimize(tree, optimizer.id, short_budget())) < 0.95 * sah_cost(tree));
    }
}

TEST_CASE("optimizers: small trees, inactive triangles, none at all") {
    for (const std::uint32_t count : {0u, 1u, 2u, 3u, 4u, 5u, 8u, 9u}) {
        Mesh mesh = random_triangles(count);
        if (count > 4) deactivate_triangles(mesh, 1, 3);
        for (const char* const builder : {"lbvh", "sweep-sah"}) {
            for (const OptimizerInfo& optimizer : tree_optimizers())
                expect_improved(optimizer.id, built_tree(builder, mesh), mesh, std::to_string(count));
        }
    }
}

TEST_CASE("optimizers: equal boxes, boxes without area and hard sets of boxes end") {
    std::vector<std::pair<std::string, Mesh>> meshes{{"equal", coincident_triangles(3000)},
                                                     {"line", line_of_points(3000)}};
    for (const BoxSet& set : hard_box_sets(500))
        meshes.emplace_back(set.name, mesh_of_boxes(set.boxes));
    for (const auto& [name, mesh] : meshes) {
        const Bvh tree = built_tree("plocpp", mesh);
        for (const OptimizerInfo& optimizer : tree_optimizers())
            expect_improved(optimizer.id, tree, mesh, name);
    }
}

TEST_CASE("optimizers: a tree that is a chain of a thousand nodes is no obstacle") {
    const Mesh mesh = random_triangles(1001);
    const Bvh tree = chain_tree(mesh);
    REQUIRE(validate(tree, mesh).depth == 1000);
    for (const OptimizerInfo& optimizer : tree_optimizers()) {
        expect_improved(optimizer.id, tree, mesh, "a chain");
        CHECK(sah_cost(optimize(tree, optimizer.id, short_budget())) < 0.8 * sah_cost(tree));
    }
    const Mesh long_mesh = coincident_triangles(100000);
    const Bvh long_tree = chain_tree(long_mesh);
    for (const OptimizerInfo& optimizer : tree_optimizers()) {
        INFO(optimizer.id);
        OptimizeBudget budget;
        budget.passes = 2;
        CHECK(validate(optimize(long_tree, optimizer.id, budget), long_mesh).error == "");
    }
}

TEST_CASE("optimizers: slots that no node uses may hold anything, and stay") {
    const Mesh mesh = random_triangles(400);
    const Bvh tight = built_tree("lbvh", mesh);
    const Bvh tree = with_strays(tight);
    REQUIRE(validate(tree, mesh).error == "");
    for (const OptimizerInfo& optimizer : tree_optimizers()) {
        INFO(optimizer.id);
        const Bvh better = optimize(tree, optimizer.id, short_budget());
        CHECK(validate(better, mesh).error == "");
        CHECK(sah_cost(better) == Approx(sah_cost(optimize(tight, optimizer.id, short_budget()))).epsilon(0.1));
    }
}

TEST_CASE("optimizers: the same bytes on one thread and on four, and again") {
    const Mesh mesh = generate_scene("city", 30000);
    const Bvh tree = built_tree("lbvh", mesh);
    for (const OptimizerInfo& optimizer : tree_optimizers()) {
        INFO(optimizer.id);
        const Bvh one = on_threads(1, optimizer.id, tree);
        CHECK(same_bytes(one, on_threads(4, optimizer.id, tree)));
        CHECK(same_bytes(one, on_threads(4, optimizer.id, tree)));
        CHECK_FALSE(same_bytes(one, tree));
    }
}

TEST_CASE("optimizers: passes and time are kept to") {
    const Mesh mesh = generate_scene("city", 20000);
    const Bvh tree = built_tree("lbvh", mesh);
    for (const OptimizerInfo& optimizer : tree_optimizers()) {
        INFO(optimizer.id);
        OptimizeStats stats;
        OptimizeBudget one_pass;
        one_pass.passes = 1;
        const Bvh after_one = optimize(tree, optimizer.id, one_pass, &stats);
        CHECK(stats.passes == 1);
        CHECK(is_no_dearer(sah_cost(after_one), sah_cost(tree)));
        OptimizeBudget no_time;
        no_time.milliseconds = 1e-9;
        CHECK(is_no_dearer(sah_cost(optimize(tree, optimizer.id, no_time, &stats)), sah_cost(tree)));
        CHECK(stats.passes == 0);
        CHECK_FALSE(stats.is_cancelled);
    }
}

TEST_CASE("optimizers: a time that is negative or not a number is refused by name, whatever the tree") {
    const Bvh leaf = make_builder("median").build(generate_scene("soup", 1));
    const Bvh tree = make_builder("median").build(generate_scene("soup", 10));
    for (const OptimizerInfo& optimizer : tree_optimizers()) {
        INFO(optimizer.id);
        OptimizeBudget budget;
        for (const double milliseconds : {-1.0, std::numeric_limits<double>::quiet_NaN()}) {
            budget.milliseconds = milliseconds;
            for (const Bvh& given : {leaf, tree}) {
                expect_error(ErrorCode::invalid_input, {"milliseconds", "0 or more"},
                             [&] { static_cast<void>(optimize(given, optimizer.id, budget)); });
            }
        }
        budget.milliseconds = std::numeric_limits<double>::infinity();
        CHECK_NOTHROW(optimize(tree, optimizer.id, budget));
    }
}

TEST_CASE("optimizers: whenever they are cancelled, the tree is valid and no dearer") {
    const Mesh mesh = generate_scene("city", 5000);
    const Bvh tree = built_tree("lbvh", mesh);
    for (const OptimizerInfo& optimizer : tree_optimizers()) {
        for (const int calls : {0, 1, 2, 5}) {
            INFO(optimizer.id << " after " << calls << " calls");
            int left = calls;
            double last = 0.0;
            OptimizeBudget budget = short_budget();
            budget.progress = [&](const Progress& progress) {
                CHECK_FALSE(progress.stage.empty());
                CHECK(progress.fraction >= last);
                CHECK(progress.fraction <= 1.0);
                last = progress.fraction;
                return left-- > 0;
            };
            OptimizeStats stats;
            const Bvh better = optimize(tree, optimizer.id, budget, &stats);
            CHECK(validate(better, mesh).error == "");
            CHECK(is_no_dearer(sah_cost(better), sah_cost(tree)));
            if (calls == 0) {
                CHECK(stats.is_cancelled);
                CHECK(stats.passes == 0);
            }
        }
    }
}

TEST_CASE("optimizers: several run one after the other, also behind a builder, and unknown ones are named") {
    const Mesh mesh = generate_scene("city", 10000);
    const Bvh tree = built_tree("lbvh", mesh);
    CHECK(same_bytes(optimize(tree, "rotate,reinsert"), optimize(optimize(tree, "rotate"), "reinsert")));
    CHECK(same_bytes(optimize(tree, ""), tree));
    for (const char* const builder : {"lbvh", "sbvh"}) {
        if (!can_run(builder)) continue;
        BuildOptions options;
        options.max_leaf_size = 4;
        const Bvh plain = make_builder(builder, options).build(mesh);
        options.optimizers = "treelet,reinsert";
        BuildStats stats;
        const Bvh better = make_builder(builder, options).build(mesh, &stats);
        CHECK(validate(better, mesh).error == "");
        CHECK(sah_cost(better) < sah_cost(plain));
        CHECK(stage(stats, "treelet").host_ms > 0.0);
        CHECK(stage(stats, "reinsert").host_ms > 0.0);
    }
    for (const char* const ids : {"none", "rotate,none", "rotate,", ",rotate"}) {
        INFO(ids);
        expect_error(ErrorCode::invalid_input, {"unknown optimizer", "reinsert, reinsert-batches"},
                     [&] { static_cast<void>(optimize(tree, ids)); });
        BuildOptions options;
        options.optimizers = ids;
        expect_error(ErrorCode::invalid_input, {"unknown optimizer"},
                     [&] { static_cast<void>(make_builder("median", options)); });
    }
}

TEST_CASE("optimizers: the progress of several is one, and never falls") {
    const Mesh mesh = generate_scene("city", 5000);
    const Bvh tree = built_tree("lbvh", mesh);
    double last = 0.0, rotated = 1.0;
    OptimizeBudget budget = short_budget();
    budget.progress = [&](const Progress& progress) {
        CHECK(progress.fraction >= last);
        CHECK(progress.fraction <= 1.0);
        last = progress.fraction;
        if (progress.stage == "rotate") rotated = last;
        return true;
    };
    static_cast<void>(optimize(tree, "rotate,reinsert", budget));
    CHECK(rotated <= 0.5);
    CHECK(last >= 0.5);
}

TEST_CASE("optimizers: a build with one can be cancelled in it, and then built again") {
    const Mesh mesh = generate_scene("city", 20000);
    for (const char* const id : {"binned-sah", "lbvh"}) {
        if (!can_run(id)) continue;
        BuildOptions options;
        options.optimizers = "rotate";
        const Bvh expected = make_builder(id, options).build(mesh);
        bool cancels = true;
        options.progress = [&](const Progress& progress) { return progress.stage != "rotate" || !cancels; };
        Builder builder = make_builder(id, options);
        builder.upload(mesh);
        expect_error(ErrorCode::cancelled, {"cancelled"}, [&] { static_cast<void>(builder.run()); });
        cancels = false;
        builder.run();  // over the mesh that is there
        CHECK(same_bytes(builder.download(), expected));
        CHECK(same_bytes(builder.build(mesh), expected));
    }
}
