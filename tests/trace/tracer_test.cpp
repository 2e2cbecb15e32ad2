#include "clbvh/trace/tracer.hpp"
#include "clbvh/trace/binary_tracer.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <vector>

#include "clbvh/builder.hpp"
#include "clbvh/io/scene.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"
#include "support/oracle/ray_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

struct Tree {
    std::string name;
    Bvh bvh;
};

/// The trees of every host builder over the mesh, with leaves of one and of several triangles, and with split
/// triangles.
std::vector<Tree> host_trees(const Mesh& mesh) {
    std::vector<Tree> trees;
    for (const BuilderInfo& info : builders()) {
        if (info.kind != BuilderKind::host) continue;
        for (const auto& [presplit, max_leaf] : {std::pair{0u, 0u}, std::pair{0u, 8u}, std::pair{14u, 4u}}) {
            BuildOptions options;
            options.presplit_level = presplit;
            options.max_leaf_size = max_leaf;
            trees.push_back(
                {std::string(info.id) + (presplit > 0 ? " presplit" : "") + " leaves of " + std::to_string(max_leaf),
                 build(mesh, info.id, options)});
        }
    }
    return trees;
}

/// How many of the rays get another closest hit, or another answer from any(), than without a tree.
std::size_t count_differences(const Bvh& bvh, const Mesh& mesh, std::span<const Ray> rays,
                              std::span<const Hit> expected, TriangleTest test = TriangleTest::watertight) {
    const Tracer tracer(bvh, mesh, {test});
    const BinaryTracer binary(bvh, mesh, {test});
    std::size_t differences = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        RayCounts counts;
        const bool agrees = same_bits(tracer.closest(rays[i]), expected[i]) &&
                            same_bits(binary.closest(rays[i], counts), expected[i]) &&
                            tracer.any(rays[i]) == static_cast<bool>(expected[i]);
        if (!agrees) ++differences;
    }
    return differences;
}

std::vector<Hit> closest_without_tree(const Mesh& mesh, std::span<const Ray> rays, TriangleTest test) {
    std::vector<Hit> hits;
    for (const Ray& ray : rays)
        hits.push_back(brute_force_closest(mesh, ray, test));
    return hits;
}

/// At most `most` of them.
std::vector<Hit> all_hits(const Tracer& tracer, const Ray& ray,
                          std::size_t most = std::numeric_limits<std::size_t>::max()) {
    std::vector<Hit> hits;
    tracer.all(ray, [&](const Hit& hit) {
        hits.push_back(hit);
        return hits.size() < most;
    });
    return hits;
}

}  // namespace

TEST_CASE("the closest hit does not depend on the tree, and any() tells whether there is one") {
    for (const SceneGeneratorInfo& scene : scene_generators()) {
        const Mesh mesh = generate_scene(scene.name, 300);
        const std::vector<Ray> rays = difficult_rays(mesh, 40);
        const std::vector<Tree> trees = host_trees(mesh);
        for (const TriangleTest test : {TriangleTest::watertight, TriangleTest::moller_trumbore}) {
            const std::vector<Hit> expected = closest_without_tree(mesh, rays, test);
            for (const Tree& tree : trees) {
                INFO(scene.name << ", " << tree.name << ", test " << static_cast<int>(test));
                CHECK(count_differences(tree.bvh, mesh, rays, expected, test) == 0);
            }
        }
    }
}

TEST_CASE("the closest hit does not depend on a tree that a device built") {
    for (const char* scene : {"soup", "city", "hair"}) {
        const Mesh mesh = generate_scene(scene, 300);
        const std::vector<Ray> rays = difficult_rays(mesh, 40);
        const std::vector<Hit> expected = closest_without_tree(mesh, rays, TriangleTest::watertight);
        for (const std::string_view id : device_builders()) {
            INFO(scene << ", " << id);
            const Bvh bvh = built_tree(id, mesh);
            CHECK(count_differences(bvh, mesh, rays, expected) == 0);
        }
    }
}

TEST_CASE("all hits come in order, each primitive once, and as often as the caller wants") {
    for (const char* scene : {"soup", "hair", "city", "terrain"}) {
        const Mesh mesh = generate_scene(scene, 400);
        const std::vector<Ray> rays = difficult_rays(mesh, 40);
        for (const Tree& tree : host_trees(mesh)) {
            INFO(scene << ", " << tree.name);
            const Tracer tracer(tree.bvh, mesh);
            std::size_t differences = 0;
            for (const Ray& ray : rays) {
                const std::vector<Hit> expected = brute_force_all(mesh, ray);
                if (!std::ranges::equal(all_hits(tracer, ray), expected, same_bits)) ++differences;
                if (!expected.empty() && all_hits(tracer, ray, 1).size() != 1) ++differences;
            }
            CHECK(differences == 0);
        }
    }
}

TEST_CASE("rays that hit nothing by definition cost nothing") {
    const Mesh mesh = generate_scene("soup", 2000);
    const Bvh bvh = build(mesh, "binned-sah");
    const Tracer tracer(bvh, mesh);
    const BinaryTracer binary(bvh, mesh);
    for (const Ray& ray : untraceable_rays()) {
        INFO(ray.origin.x << ' ' << ray.direction.x << ' ' << ray.t_min << ' ' << ray.t_max);
        RayCounts counts;
        CHECK(same_bits(tracer.closest(ray), Hit{}));
        CHECK_FALSE(tracer.any(ray));
        CHECK(same_bits(binary.closest(ray, counts), Hit{}));
        CHECK_FALSE(binary.any(ray, counts));
        CHECK(counts == RayCounts{});
        CHECK(binary.visits(ray) == RayCounts{});
        CHECK(all_hits(tracer, ray).empty());
    }
}

TEST_CASE("a t_min below 0 counts as 0, and both ends of a ray belong to it") {
    const Mesh mesh{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}, {{0, 1, 2}}};
    const Tracer tracer(build(mesh, "median"), mesh);
    CHECK(tracer.closest({{1, 1, -2}, -8.0f, {0, 0, 1}, 2.0f}).t == 2.0f);
    CHECK(tracer.closest({{1, 1, -2}, 2.0f, {0, 0, 1}, 2.0f}).t == 2.0f);
    CHECK(tracer.closest({{1, 1, 0}, -8.0f, {0, 0, 1}, 0.0f}).t == 0.0f);
    CHECK_FALSE(tracer.any({{1, 1, 1}, -8.0f, {0, 0, 1}, 2.0f}));
    CHECK_FALSE(tracer.any({{1, 1, -2}, 0.0f, {0, 0, 1}, 1.9999999f}));
    CHECK_FALSE(tracer.any({{1, 1, -2}, 2.0000003f, {0, 0, 1}, 3.0f}));
    CHECK(tracer.closest({{1, 0.5f, -2}, 0.0f, {0, 0, 4}}) == Hit{0.5f, 0.25f, 0.125f, 0});
}

TEST_CASE("an empty tree is missed") {
    const Mesh mesh;
    const Tracer tracer(build(mesh, "median"), mesh);
    const Ray ray{{0, 0, 0}, 0.0f, {0, 0, 1}};
    CHECK_FALSE(tracer.closest(ray));
    CHECK_FALSE(tracer.any(ray));
    const BinaryTracer binary(build(mesh, "median"), mesh);
    CHECK(binary.visits(ray) == RayCounts{});
    CHECK(binary.depth() == 0);
    CHECK(all_hits(tracer, ray).empty());
}

TEST_CASE("primitives with a NaN are never hit, even where a tree names them") {
    Mesh mesh = generate_scene("soup", 500);
    const Bvh bvh = build(mesh, "binned-sah");
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
        Vec3& vertex = mesh.vertices[mesh.triangles[i][i % 3 == 0 ? 1 : 2]];
        (i % 2 == 0 ? vertex.x : vertex.z) = std::numeric_limits<float>::quiet_NaN();
    }
    const std::vector<Ray> rays = difficult_rays(mesh, 100);
    for (const TriangleTest test : {TriangleTest::watertight, TriangleTest::moller_trumbore}) {
        const Tracer tracer(bvh, mesh, {test});
        std::size_t wrong = 0;
        for (const Ray& ray : rays) {
            for (const Hit& hit : all_hits(tracer, ray))
                wrong += is_inactive(mesh, hit.primitive) ? 1 : 0;
            const Hit closest = tracer.closest(ray);
            if (closest && is_inactive(mesh, closest.primitive)) ++wrong;
        }
        CHECK(wrong == 0);
    }
}

TEST_CASE("many rays at a time are traced as one by one, on any number of threads") {
    const Mesh mesh = generate_scene("clustered", 3000);
    const Bvh bvh = build(mesh, "binned-sah");
    const std::vector<Ray> rays = difficult_rays(mesh, 300);
    for (const std::uint32_t threads : {0u, 1u, 2u, 7u}) {
        const Tracer tracer(bvh, mesh, {TriangleTest::watertight, threads});
        const BinaryTracer binary(bvh, mesh, {TriangleTest::watertight, threads});
        std::vector<Hit> hits(rays.size()), counted_hits(rays.size());
        std::vector<std::uint8_t> any(rays.size(), 9), counted_any(rays.size(), 9);
        std::vector<RayCounts> closest_counts(rays.size(), {9, 9, 9, 9}), any_counts(rays.size()), visits(rays.size());
        tracer.closest(rays, hits);
        binary.closest(rays, counted_hits, closest_counts);
        tracer.any(rays, any);
        binary.any(rays, counted_any, any_counts);
        binary.visits(rays, visits);
        std::size_t differences = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            RayCounts closest_count, any_count;
            const Hit hit = binary.closest(rays[i], closest_count);
            const bool is_hit = binary.any(rays[i], any_count);
            const bool agrees = same_bits(hits[i], hit) && same_bits(counted_hits[i], hit) && any[i] == is_hit &&
                                counted_any[i] == is_hit && closest_counts[i] == closest_count &&
                                any_counts[i] == any_count && visits[i] == binary.visits(rays[i]);
            if (!agrees) ++differences;
        }
        CHECK(differences == 0);
    }
}

TEST_CASE("spans of another length are refused") {
    const Mesh mesh = generate_scene("soup", 10);
    const Bvh bvh = build(mesh, "median");
    const Tracer tracer(bvh, mesh);
    const BinaryTracer binary(bvh, mesh);
    const std::vector<Ray> rays(3);
    std::vector<Hit> hits(2);
    std::vector<std::uint8_t> any(4);
    std::vector<RayCounts> counts(2);
    expect_error(ErrorCode::invalid_input, {"hits", "2", "3"}, [&] { tracer.closest(rays, hits); });
    expect_error(ErrorCode::invalid_input, {"is_hit", "4", "3"}, [&] { tracer.any(rays, any); });
    expect_error(ErrorCode::invalid_input, {"counts", "2", "3"}, [&] { binary.visits(rays, counts); });
    expect_error(ErrorCode::invalid_input, {"thread_count", "1025"}, [&] {
        Tracer(build(mesh, "median"), mesh, {TriangleTest::watertight, 1025});
    });
}

TEST_CASE("a filter decides which hits count") {
    for (const char* scene : {"hair", "soup"}) {
        const Mesh mesh = generate_scene(scene, 2000);
        const Tracer tracer(build(mesh, "binned-sah"), mesh);
        const auto is_solid = [](const Ray&, const Hit& hit) { return hit.primitive % 3 != 0; };
        const std::vector<Ray> rays = difficult_rays(mesh, 200);
        std::vector<Hit> hits(rays.size());
        std::vector<std::uint8_t> is_hit(rays.size());
        tracer.closest(rays, hits, is_solid);
        tracer.any(rays, is_hit, is_solid);
        std::size_t differences = 0, passed = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            Hit expected;
            for (const Hit& hit : all_hits(tracer, rays[i])) {
                if (is_solid(rays[i], hit)) {
                    expected = hit;
                    break;
                }
                ++passed;
            }
            differences += same_bits(hits[i], expected) && is_hit[i] == (expected ? 1 : 0) ? 0 : 1;
        }
        CHECK(differences == 0);
        CHECK(passed > 100);
    }
}

TEST_CASE("what a filter throws leaves the call") {
    const Mesh mesh = generate_scene("soup", 200);
    const Tracer tracer(build(mesh, "binned-sah"), mesh);
    const std::vector<Ray> rays = difficult_rays(mesh, 200);
    std::vector<Hit> hits(rays.size());
    const auto fail = [](const Ray&, const Hit&) -> bool { throw std::runtime_error("no texture"); };
    CHECK_THROWS_WITH(tracer.closest(rays, hits, fail), "no texture");
}

TEST_CASE("all hits of many rays are those of each") {
    const Mesh mesh = generate_scene("hair", 2000);
    const Tracer tracer(build(mesh, "binned-sah"), mesh);
    const std::vector<Ray> rays = difficult_rays(mesh, 300);
    const HitLists lists = tracer.all(rays);
    REQUIRE(lists.begins.size() == rays.size() + 1);
    CHECK(lists.begins.front() == 0);
    CHECK(lists.begins.back() == lists.hits.size());
    std::size_t differences = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const auto found = std::span(lists.hits).subspan(lists.begins[i], lists.begins[i + 1] - lists.begins[i]);
        differences += std::ranges::equal(found, all_hits(tracer, rays[i]), same_bits) ? 0 : 1;
    }
    CHECK(differences == 0);
    CHECK(tracer.all(std::span<const Ray>{}).begins == std::vector<std::uint64_t>{0});
}

TEST_CASE("a tracer borrows a layout, or owns it") {
    const Mesh mesh = generate_scene("city", 3000), other = generate_scene("city", 3000, 5);
    const Bvh bvh = build(mesh, "binned-sah"), other_bvh = build(other, "binned-sah");
    const std::vector<Ray> rays = difficult_rays(mesh, 300);
    const auto differences = [&](const Tracer& a, const Tracer& b) {
        std::size_t count = 0;
        for (const Ray& ray : rays)
            count += same_bits(a.closest(ray), b.closest(ray)) ? 0 : 1;
        return count;
    };
    Wide8 layout = make_layout<Wide8>(bvh, mesh);
    const Tracer borrower(std::as_const(layout));
    CHECK(&borrower.layout() == &layout);
    CHECK(differences(borrower, Tracer(bvh, mesh)) == 0);
    make_layout(other_bvh, other, layout);
    CHECK(differences(borrower, Tracer(other_bvh, other)) == 0);
    CHECK(differences(borrower, Tracer(bvh, mesh)) > 0);
    const Tracer owner(std::move(layout));
    CHECK(differences(owner, Tracer(other_bvh, other)) == 0);
}
