// Refitted trees are valid over the moved mesh, with the cost that sah_cost() sees, or nothing is changed.
#include "clbvh/optimize/refit.hpp"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <span>
#include <string>

#include "clbvh/core/validate.hpp"
#include "clbvh/io/scene.hpp"
#include "optimize/refit_plan.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"
#include "support/fitted_by_definition.hpp"
#include "support/hard_trees.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

Mesh twisted(Mesh mesh) {
    for (Vec3& vertex : mesh.vertices)
        vertex = {vertex.x + 0.3f * std::sin(5.0f * vertex.y), vertex.y, -vertex.z};
    return mesh;
}

}  // namespace

TEST_CASE("refit: the tree of every builder fits the moved mesh, and both costs are told") {
    for (const char* const scene : {"city", "clustered", "hair"}) {
        const Mesh mesh = generate_scene(scene, 3000);
        const Mesh moved = twisted(mesh);
        for (const BuilderInfo& builder : builders()) {
            for (const std::uint32_t leaf_size : {0u, 8u}) {
                INFO(scene << ", " << builder.id << ", leaves of " << leaf_size);
                BuildOptions options;
                options.max_leaf_size = leaf_size;
                Bvh tree = built_tree(builder.id, mesh, options);
                const double before = sah_cost(tree);
                const SahCosts costs{2.0, 0.5};
                const double dear_before = sah_cost(tree, costs);
                Bvh again = tree;
                const Bvh expected = fitted_by_definition(tree, moved);
                const RefitStats stats = refit(tree, moved);
                CHECK(same_bytes(tree, expected));
                CHECK(validate(tree, moved).error == "");
                CHECK(stats.sah_before == Approx(before).epsilon(1e-9));
                CHECK(stats.sah_after == Approx(sah_cost(tree)).epsilon(1e-9));
                CHECK(refit(again, moved, costs).sah_before == Approx(dear_before).epsilon(1e-9));
            }
        }
    }
}

TEST_CASE("refit: a mesh that did not move changes no byte") {
    const Mesh mesh = generate_scene("terrain", 5000);
    const Bvh tree = built_tree("plocpp", mesh);
    Bvh fitted = tree;
    const RefitStats stats = refit(fitted, mesh);
    CHECK(same_bytes(fitted, tree));
    CHECK(stats.sah_before == stats.sah_after);
}

TEST_CASE("refit: no triangle, one, and inactive ones") {
    for (const std::uint32_t count : {0u, 1u, 2u, 50u}) {
        Mesh mesh = random_triangles(count);
        if (count == 50) deactivate_triangles(mesh, 3, 7);
        Bvh tree = make_builder("binned-sah").build(mesh);
        const Mesh moved = scaled(mesh, 2.0f);
        const RefitStats stats = refit(tree, moved);
        CHECK(validate(tree, moved).error == "");
        CHECK(stats.sah_after == Approx(sah_cost(tree)));
    }
}

TEST_CASE("refit: where the root has no area all nodes count as hit, before and after") {
    const Mesh line = line_of_points(3000);
    for (const std::uint32_t leaf_size : {0u, 8u}) {
        BuildOptions options;
        options.max_leaf_size = leaf_size;
        Bvh tree = built_tree("plocpp", line, options);
        Refitter refitter(tree);
        double cost = sah_cost(tree);
        for (const Mesh& frame : flat_and_other_frames(line)) {
            const RefitStats stats = refitter.refit(tree, frame);
            CHECK(stats.sah_before == Approx(cost).epsilon(1e-9));
            cost = sah_cost(tree);
            CHECK(cost > 0.0);
            CHECK(stats.sah_after == Approx(cost).epsilon(1e-9));
        }
    }
}

TEST_CASE("refit: another mesh is refused, and the tree stays as it was") {
    const Mesh mesh = random_triangles(100);
    Mesh some_inactive = mesh;
    deactivate_triangles(some_inactive, 10, 1000);
    const Bvh whole = make_builder("sweep-sah").build(mesh);
    const Bvh partial = make_builder("sweep-sah").build(some_inactive);
    const auto expect_refused = [](const Bvh& tree, const Mesh& other, std::initializer_list<std::string> words) {
        Bvh fitted = tree;
        expect_error(ErrorCode::invalid_input, words, [&] { refit(fitted, other); });
        CHECK(same_bytes(fitted, tree));
    };
    expect_refused(whole, random_triangles(99), {"99 triangles", "100"});
    expect_refused(whole, some_inactive, {"triangle 10", "NaN"});
    expect_refused(partial, mesh, {"triangle 10", "not in the tree"});
    Bvh costly = whole;
    expect_error(ErrorCode::invalid_input, {"cost"}, [&] { refit(costly, mesh, {-1.0, 1.0}); });
    CHECK(same_bytes(costly, whole));
    Mesh infinite = mesh;
    infinite.vertices[infinite.triangles[7][1]].y = std::numeric_limits<float>::infinity();
    expect_refused(whole, infinite, {"triangle 7"});
}

TEST_CASE("refit: more slots than a plan can number are refused before they are read") {
    const Node node{};
    const std::size_t most = optimizer::RefitPlan::kMostSlots;
    CHECK(most == 2 * kMaxPrimitives);
    expect_error(ErrorCode::unsupported, {std::to_string(most + 2), std::to_string(most)},
                 [&] { const optimizer::RefitPlan plan(std::span<const Node>(&node, most + 2)); });
}

TEST_CASE("refitter: again and again what refit gives, on any number of threads") {
    const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 8);
    Mesh mesh = generate_scene("city", 40000);
    for (const char* const builder : {"lbvh", "plocpp", "sbvh", "sweep-sah"}) {
        for (const std::uint32_t leaf_size : {0u, 4u}) {
            INFO(builder << ", leaves of " << leaf_size);
            BuildOptions options;
            options.max_leaf_size = leaf_size;
            Bvh tree = built_tree(builder, mesh, options);
            Refitter refitter(tree);
            double last = sah_cost(tree);
            for (int frame = 0; frame < 3; ++frame) {
                mesh = twisted(std::move(mesh));
                Bvh other = tree;
                const RefitStats stats = refitter.refit(tree, mesh);
                CHECK(same_bytes(tree, fitted_by_definition(tree, mesh)));
                CHECK(stats.sah_before == Approx(last).epsilon(1e-12));
                last = sah_cost(tree);
                CHECK(stats.sah_after == Approx(last).epsilon(1e-12));
                CHECK(stats.rise() == Approx(stats.sah_after / stats.sah_before));
                const RefitStats on_one = tbb::task_arena(1).execute([&] { return refitter.refit(other, mesh); });
                CHECK(same_bytes(tree, other));
                CHECK(on_one.sah_before == stats.sah_before);
                CHECK(on_one.sah_after == stats.sah_after);
            }
        }
    }
}

TEST_CASE("refitter: hard trees") {
    const Mesh mesh = random_triangles(30000);
    const Mesh mesh_moved = twisted(mesh);
    Bvh chain = chain_tree(mesh);
    Refitter refitter(chain);
    Refitter moved_here = std::move(refitter);
    refitter = std::move(moved_here);
    static_cast<void>(refitter.refit(chain, mesh_moved));
    CHECK(validate(chain, mesh_moved).error == "");

    // Memory between the slots in use stays.
    const Mesh small = random_triangles(3000);
    const Bvh tight = built_tree("plocpp", small);
    Bvh sparse = with_strays(tight);
    const Node stray = sparse.nodes[6];
    const Mesh turned = twisted(small);
    Refitter of_sparse(sparse);
    CHECK(of_sparse.refit(sparse, turned).sah_after == Approx(sah_cost(fitted_by_definition(tight, turned))));
    CHECK(validate(sparse, turned).error == "");
    CHECK(sparse.nodes[6] == stray);

    for (const std::uint32_t count : {0u, 1u, 2u, 3u}) {
        const Mesh few = random_triangles(count);
        Bvh tree = built_tree("lbvh", few);
        Refitter of_few(tree);
        const RefitStats stats = of_few.refit(tree, scaled(few, 2.0f));
        CHECK(validate(tree, scaled(few, 2.0f)).error == "");
        CHECK(stats.sah_after == Approx(sah_cost(tree)));
    }
    CHECK(RefitStats{}.rise() == 1.0);
}

TEST_CASE("refitter: other trees and meshes are refused") {
    const Mesh mesh = random_triangles(1000);
    const Bvh tree = built_tree("lbvh", mesh);
    Refitter refitter(tree);
    const auto expect_untouched = [&](const Bvh& given, const Mesh& other, std::initializer_list<std::string> words) {
        Bvh fitted = given;
        expect_error(ErrorCode::invalid_input, words, [&] { refitter.refit(fitted, other); });
        CHECK(same_bytes(fitted, given));
    };
    Mesh infinite = mesh;
    infinite.vertices[7].y = std::numeric_limits<float>::infinity();
    expect_untouched(tree, infinite, {"triangle 2"});
    expect_untouched(tree, random_triangles(999), {"999 triangles"});
    expect_untouched(built_tree("lbvh", random_triangles(999)), random_triangles(999), {"nodes", "1998"});

    // As many nodes, but others: found out, and mended by refit().
    Bvh other = built_tree("plocpp", mesh);
    expect_error(ErrorCode::invalid_input, {"not those that the refitter was made for"},
                 [&] { refitter.refit(other, mesh); });
    refit(other, mesh);
    CHECK(validate(other, mesh).error == "");

    // The same nodes over other primitives are served.
    Bvh reversed = tree;
    std::ranges::reverse(reversed.primitive_ids);
    refitter.refit(reversed, mesh);
    CHECK(validate(reversed, mesh).error == "");
}
