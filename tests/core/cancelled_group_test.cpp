#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "clbvh/builder.hpp"
#include "clbvh/catalog.hpp"
#include "clbvh/core/validate.hpp"
#include "clbvh/eval/ray_sets.hpp"
#include "clbvh/host/collapse.hpp"
#include "clbvh/host/presplit.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/layout/compressed8.hpp"
#include "clbvh/layout/pair.hpp"
#include "clbvh/layout/skip.hpp"
#include "clbvh/layout/wide.hpp"
#include "clbvh/metrics/epo.hpp"
#include "clbvh/metrics/sah.hpp"
#include "clbvh/metrics/surface_ray_cost.hpp"
#include "clbvh/optimize/refit.hpp"
#include "clbvh/trace/tracer.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

/// Runs `work` as a task of a group that the program has cancelled.
template <typename Work>
void in_cancelled_group(const Work& work) {
    tbb::task_group_context group;
    bool ran = false;
    tbb::parallel_for(
        0, 1,
        [&](int) {
            group.cancel_group_execution();
            work();
            ran = true;
        },
        group);
    REQUIRE(ran);
}

void check_same(const Bvh& a, const Bvh& b) {
    CHECK((a.nodes == b.nodes));  // not printed
    CHECK((a.primitive_ids == b.primitive_ids));
}

/// Builders and presets, where there is no device those that need none.
std::vector<std::string> ids_that_run() {
    std::vector<std::string> ids;
    for (const BuilderInfo& builder : builders()) {
        if (can_run(builder.id)) ids.emplace_back(builder.id);
    }
    for (const PresetInfo& preset : presets()) {
        if (can_run(preset.id)) ids.emplace_back(preset.id);
    }
    return ids;
}

Mesh moved(Mesh mesh) {
    for (Vec3& vertex : mesh.vertices)
        vertex.x += 5.0f;
    return mesh;
}

}  // namespace

TEST_CASE("every builder makes its tree within a group of tasks that is cancelled") {
    const Mesh mesh = load_scene("gen:soup:20000");
    for (const std::string& id : ids_that_run()) {
        INFO(id);
        const Bvh expected = build(mesh, id);
        in_cancelled_group([&] {
            const Bvh tree = build(mesh, id);
            check_same(tree, expected);
            CHECK(validate(tree, mesh).valid);
        });
    }
}

TEST_CASE("optimisers work within a group of tasks that is cancelled") {
    const Mesh mesh = load_scene("gen:soup:20000");
    for (const OptimizerInfo& optimizer : optimizers()) {
        INFO(optimizer.id);
        BuildOptions options;
        options.optimizers = std::string(optimizer.id);
        const Bvh expected = build(mesh, "median", options);
        in_cancelled_group([&] { check_same(build(mesh, "median", options), expected); });
    }
}

TEST_CASE("checks and metrics look at everything within a group of tasks that is cancelled") {
    const Mesh mesh = load_scene("gen:soup:60000");
    const Bvh tree = build(mesh, "binned-sah");
    Bvh wrong = tree;
    wrong.nodes[wrong.nodes.size() - 1].lower[0] += 1.0f;
    Mesh bad = mesh;
    bad.triangles[50000][0] = 4000000000U;
    const double sah = sah_cost(tree), epo = end_point_overlap_sampled(tree, mesh, 20000, 1).value;
    const Mesh there = moved(mesh);
    in_cancelled_group([&] {
        CHECK_FALSE(validate(wrong, mesh).valid);
        expect_error(ErrorCode::invalid_input, {"50000"}, [&] { (void)check_mesh(bad); });
        CHECK(sah_cost(tree) == sah);
        CHECK(end_point_overlap_sampled(tree, mesh, 20000, 1).value == epo);
        Bvh refitted = tree;
        (void)refit(refitted, there);
        CHECK(validate(refitted, there).valid);
    });
}

TEST_CASE("rays and layouts are complete within a group of tasks that is cancelled") {
    const Mesh mesh = load_scene("gen:soup:60000");
    const Tracer tracer(build(mesh, "binned-sah"), mesh);
    const std::vector<Ray> rays = random_lines(Aabb{{0, 0, 0}, {1, 1, 1}}, 20000, 3);
    std::vector<Hit> expected(rays.size()), hits(rays.size());
    tracer.closest(rays, expected);
    in_cancelled_group([&] {
        CHECK(random_lines(Aabb{{0, 0, 0}, {1, 1, 1}}, 20000, 3).back() == rays.back());
        tracer.closest(rays, hits);
        CHECK(hits == expected);
        const Tracer made(build(mesh, "binned-sah"), mesh);
        std::vector<Hit> others(rays.size());
        made.closest(rays, others);
        CHECK(others == expected);
        validate(made.layout(), mesh);
    });
}

TEST_CASE("leaves are merged, triangles split and all layouts made within a group of tasks that is cancelled") {
    const Mesh mesh = load_scene("gen:soup:60000");
    const Bvh tree = build(mesh, "median");
    const Bvh merged = collapse(tree);
    const PresplitMesh split = presplit(mesh);
    const double exact = end_point_overlap(merged, mesh);
    const SurfaceRayCost cost = surface_ray_cost(tree, mesh);
    in_cancelled_group([&] {
        check_same(collapse(tree), merged);
        CHECK(presplit(mesh).mesh.vertices == split.mesh.vertices);
        CHECK(end_point_overlap(merged, mesh) == exact);
        CHECK(surface_ray_cost(tree, mesh).cost == cost.cost);
        validate(make_layout<Wide4>(tree, mesh), mesh);
        validate(make_layout<Compressed8>(tree, mesh), mesh);
        SkipLayout skip;
        make_layout(tree, skip);
        validate(skip, mesh);
        PairLayout pair;
        make_layout(tree, pair);
        validate(pair, mesh);
    });
}
