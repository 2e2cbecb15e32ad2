// Refitted trees are valid over the moved mesh, with the cost that sah_cost() sees, or nothing is changed.
#include "clbvh/optimize/refit.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "clbvh/core/validate.hpp"
#include "clbvh/io/scene.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"
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
                Bvh tree = make_builder(builder.id, options).build(mesh);
                const double before = sah_cost(tree);
                const SahCosts costs{2.0, 0.5};
                const double dear_before = sah_cost(tree, costs);
                Bvh again = tree;
                const RefitStats stats = refit(tree, moved);
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
    const Bvh tree = make_builder("plocpp").build(mesh);
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
