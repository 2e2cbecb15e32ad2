// The sampled cost of rays from surfaces: against numbers worked out by hand, against random rays through BinaryTracer,
// and what it is for, trees that the SAH cost does not tell apart.
#include "clbvh/metrics/surface_ray_cost.hpp"

#include <tbb/task_arena.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "clbvh/core/vector.hpp"
#include "clbvh/host/binned_sah.hpp"
#include "clbvh/host/median.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/trace/binary_tracer.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;
using Catch::Matchers::WithinRel;

namespace {

/// Of rays of the sample's kind, which are not its own: from triangles by number and by area in turn, in all
/// directions.
double random_ray_cost(const Bvh& bvh, const Mesh& mesh, std::uint32_t count) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    std::vector<double> areas;
    const auto corner = [&](std::size_t triangle, std::size_t i) { return mesh.vertices[mesh.triangles[triangle][i]]; };
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const Vec3 a = corner(i, 1) - corner(i, 0), b = corner(i, 2) - corner(i, 0);
        const double x = a.y * b.z - a.z * b.y, y = a.z * b.x - a.x * b.z, z = a.x * b.y - a.y * b.x;
        areas.push_back(std::sqrt(x * x + y * y + z * z));
    }
    std::discrete_distribution<std::size_t> by_area(areas.begin(), areas.end());
    std::uniform_int_distribution<std::size_t> by_number(0, areas.size() - 1);
    const Aabb box = bvh.nodes[0].bounds();
    const Vec3 size = max(max(box.upper, -box.upper), max(box.lower, -box.lower));
    const BinaryTracer tracer(bvh, mesh);
    double sum = 0.0;
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::size_t triangle = i % 2 == 0 ? by_area(random) : by_number(random);
        double u = unit(random), v = unit(random);
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        const Vec3 p = corner(triangle, 0), q = corner(triangle, 1), r = corner(triangle, 2);
        Ray ray;
        ray.origin = p + static_cast<float>(u) * (q - p) + static_cast<float>(v) * (r - p);
        const double z = 1 - 2 * unit(random), angle = 2 * std::numbers::pi * unit(random);
        const double radius = std::sqrt(1 - z * z);
        ray.direction = {static_cast<float>(radius * std::cos(angle)), static_cast<float>(radius * std::sin(angle)),
                         static_cast<float>(z)};
        ray.t_min = 0x1p-18f * std::max({size.x, size.y, size.z});  // not the triangle itself
        RayCounts counts;
        static_cast<void>(tracer.closest(ray, counts));
        sum += 1.2 * counts.inner_nodes + counts.triangles;
    }
    return sum / count;
}

}  // namespace

TEST_CASE("surface ray cost: trees whose cost is plain to see") {
    const Mesh mesh = generate_scene("soup", 60);
    BinnedSahConfig one_leaf;
    one_leaf.max_leaf_size = 64;
    one_leaf.inner_cost = 1000;
    const SurfaceRayCost of_leaf = surface_ray_cost(build_binned_sah(mesh, one_leaf), mesh);
    CHECK(of_leaf.ray_count == kSurfaceRays);
    CHECK(of_leaf.counts.inner_nodes == 0);
    CHECK(of_leaf.counts.leaves == 1);
    CHECK(of_leaf.cost == 60);

    // Two triangles far apart, that hardly any ray sees both of: the root, and one's own leaf.
    Mesh pair;
    for (const float x : {0.0f, 500.0f}) {
        const auto first = static_cast<std::uint32_t>(pair.vertices.size());
        pair.vertices.insert(pair.vertices.end(), {{x, 0, 0}, {x + 1, 0, 1}, {x, 1, 0}});
        pair.triangles.push_back({first, first + 1, first + 2});
    }
    BinnedSahConfig two_leaves;
    two_leaves.max_leaf_size = 1;
    const SurfaceRayCost of_pair = surface_ray_cost(build_binned_sah(pair, two_leaves), pair, 1000, {10, 1});
    CHECK(of_pair.counts.inner_nodes == Approx(1).margin(0.02));  // some begin in a corner, and leave at once
    CHECK(of_pair.counts.triangles == Approx(1).margin(0.02));
    CHECK(of_pair.cost == Approx(10 * of_pair.counts.inner_nodes + of_pair.counts.triangles));
}

TEST_CASE("surface ray cost: random rays of the same kind cost the same") {
    for (const char* scene : {"soup", "city", "hair", "terrain", "sphere"}) {
        const Mesh mesh = generate_scene(scene, 2000);
        const Bvh trees[] = {build_binned_sah(mesh), build_median(mesh)};
        for (const Bvh& tree : trees) {
            INFO(scene);
            CHECK_THAT(surface_ray_cost(tree, mesh).cost, WithinRel(random_ray_cost(tree, mesh, 40000), 0.04));
        }
    }
}

TEST_CASE("surface ray cost: it tells trees apart that the SAH cost does not") {
    if (!can_run("lbvh")) return;
    const Mesh mesh = load_scene("gen:outlier:1000000:8000");
    BuildOptions plain;
    plain.device.morton_code = MortonCode::xyz;
    const Bvh good = make_builder("lbvh").build(mesh);
    const Bvh bad = make_builder("lbvh", plain).build(mesh);
    CHECK_THAT(sah_cost(bad), WithinRel(sah_cost(good), 0.01));
    CHECK(surface_ray_cost(bad, mesh).cost > 10 * surface_ray_cost(good, mesh).cost);
}

TEST_CASE("surface ray cost: neither threads nor the scale matter") {
    const Mesh mesh = generate_scene("city", 20000);
    const Bvh tree = build_binned_sah(mesh);
    const SurfaceRayCost expected = surface_ray_cost(tree, mesh);
    for (const int threads : {1, 2}) {
        tbb::task_arena arena(threads);
        CHECK(arena.execute([&] { return surface_ray_cost(tree, mesh).cost; }) == expected.cost);
    }
    const Mesh large = scaled(mesh, 0x1p10f);
    CHECK(surface_ray_cost(build_binned_sah(large), large).cost == expected.cost);
}

TEST_CASE("surface ray cost: scenes with nothing to begin on, and wrong input") {
    CHECK(surface_ray_cost({}, Mesh{}).ray_count == 0);
    Mesh flat = random_triangles(20);
    for (Triangle& triangle : flat.triangles)
        triangle[1] = triangle[0];
    CHECK(surface_ray_cost(build_binned_sah(flat), flat).ray_count == 0);
    Mesh mesh = random_triangles(100);
    deactivate_triangles(mesh, 3, 7);
    const Bvh tree = build_binned_sah(mesh);
    CHECK(surface_ray_cost(tree, mesh).ray_count < kSurfaceRays);
    CHECK(surface_ray_cost(tree, mesh).ray_count > kSurfaceRays / 3);

    const auto refused = [&](const char* word, std::uint32_t count, const SahCosts& costs) {
        expect_error(ErrorCode::invalid_input, {word},
                     [&] { static_cast<void>(surface_ray_cost(tree, mesh, count, costs)); });
    };
    refused("ray_count is 0", 0, {});
    refused("ray_count", kMostSurfaceRays + 1, {});
    refused("-1", 10, {-1, 1});
    const Mesh other = random_triangles(10);
    expect_error(ErrorCode::invalid_input, {"10"}, [&] { static_cast<void>(surface_ray_cost(tree, other)); });
}
