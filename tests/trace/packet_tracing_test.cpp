// Rays that are traced together find what each finds alone, to the bit.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "clbvh/builder.hpp"
#include "clbvh/core/mesh_bounds.hpp"
#include "clbvh/core/vector.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/trace/tracer.hpp"
#include "core/random.hpp"
#include "support/oracle/ray_oracle.hpp"
#include "trace/wide_tracing.hpp"

using namespace clbvh;
using namespace clbvh::test;
using namespace clbvh::trace;

namespace {

/// From one point outside of the box through a grid of points in it, line by line.
std::vector<Ray> camera_rays(const Aabb& box, std::uint32_t side) {
    const Vec3 size = box.upper - box.lower;
    const Vec3 eye = box.lower - Vec3{0.31f * size.x, 0.57f * size.y, 0.83f * size.z};
    std::vector<Ray> rays;
    for (std::uint32_t y = 0; y < side; ++y) {
        for (std::uint32_t x = 0; x < side; ++x) {
            const float across = static_cast<float>(x) / static_cast<float>(side);
            const float down = static_cast<float>(y) / static_cast<float>(side);
            const Vec3 target = box.lower + Vec3{across * size.x, down * size.y, 0.5f * size.z};
            rays.push_back({eye, 0.0f, target - eye});
        }
    }
    return rays;
}

/// Side by side in nearly one direction; then from there to one point, as to a light.
std::vector<Ray> rays_from_a_line(const Aabb& box, std::uint32_t count) {
    const Vec3 size = box.upper - box.lower;
    std::vector<Ray> rays;
    for (std::uint32_t i = 0; i < count; ++i) {
        const float along = static_cast<float>(i) / static_cast<float>(count);
        const Vec3 start = box.upper - Vec3{along * size.x, 0.3f * along * size.y, -0.1f * size.z};
        rays.push_back({start, 0.0f, {-0.01f * along * size.x - 0.1f * size.x, 0.05f * size.y, -size.z}});
    }
    for (std::uint32_t i = 0; i < count; ++i) {
        const Vec3& start = rays[i].origin;
        const Vec3 light = box.lower + Vec3{0.4f * size.x, 0.4f * size.y, 0.2f * size.z};
        rays.push_back({start, 0.0f, light - start, 1.0f});
    }
    return rays;
}

/// From anywhere in the box in any direction, so that no two have much in common.
std::vector<Ray> scattered_rays(const Aabb& box, std::uint32_t count) {
    Random random(11);
    std::vector<Ray> rays;
    while (rays.size() < count) {
        const Vec3 origin{random.between(box.lower.x, box.upper.x), random.between(box.lower.y, box.upper.y),
                          random.between(box.lower.z, box.upper.z)};
        rays.push_back({origin, 0.0f, {random.bell(), random.bell(), random.bell()}});
    }
    return rays;
}

/// The same rays with other beginnings and ends.
std::vector<Ray> with_ranges(std::vector<Ray> rays) {
    Random random(7);
    for (Ray& ray : rays) {
        ray.t_min = random.between(-0.5f, 0.9f);
        ray.t_max = random.between(0.8f, 2.0f);
        if (random.unit() < 0.2f) ray.t_max = kPositiveInfinity;
    }
    return rays;
}

/// The same rays, some of which hit nothing by definition, and some with a direction of which a part is 0.
std::vector<Ray> with_odd_ones(std::vector<Ray> rays) {
    const std::vector<Ray> untraceable = untraceable_rays();
    for (std::size_t i = 5; i < rays.size(); i += 17) {
        if (i % 2 == 0)
            rays[i] = untraceable[i % untraceable.size()];
        else
            rays[i].direction.x = i % 4 == 1 ? 0.0f : -0.0f;
    }
    return rays;
}

std::vector<Ray> rays_for(const Mesh& mesh) {
    const Aabb box = mesh_bounds(mesh);
    std::vector<Ray> rays = camera_rays(box, 40);
    const auto add = [&](const std::vector<Ray>& more) { rays.insert(rays.end(), more.begin(), more.end()); };
    add(rays_from_a_line(box, 400));
    add(scattered_rays(box, 3000));
    add(with_ranges(rays));
    add(with_odd_ones(rays));
    add(difficult_rays(mesh, 60));
    return rays;
}

/// How many of the rays find something else together than alone.
std::size_t count_differences(const Wide8& tree, const std::vector<Ray>& rays, const WideTracing& tracing) {
    std::vector<Hit> hits(rays.size());
    std::vector<std::uint8_t> any(rays.size(), 9);
    tracing.closest_of_many(tree, rays, hits.data());
    tracing.any_of_many(tree, rays, any.data());
    std::size_t differences = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const bool agrees =
            same_bits(hits[i], tracing.closest(tree, rays[i])) && any[i] == (tracing.any(tree, rays[i]) ? 1 : 0);
        if (!agrees) ++differences;
    }
    return differences;
}

void check_all(const Bvh& bvh, const Mesh& mesh, const std::vector<Ray>& rays) {
    const Wide8 tree = make_layout<Wide8>(bvh, mesh);
    for (const TriangleTest test : {TriangleTest::watertight, TriangleTest::moller_trumbore}) {
        for (const simd::InstructionSet set : simd::kInstructionSets) {
            if (!is_available(set)) continue;
            INFO("test " << static_cast<int>(test) << ", set " << simd::to_string(set));
            CHECK(count_differences(tree, rays, wide_tracing(set, test)) == 0);
        }
    }
}

}  // namespace

TEST_CASE("rays that are traced together find what each finds alone") {
    for (const char* scene : {"city", "soup", "hair", "terrain"}) {
        const Mesh mesh = generate_scene(scene, 3000);
        const std::vector<Ray> rays = rays_for(mesh);
        for (const std::string_view builder : {"binned-sah", "sbvh"}) {
            INFO(scene << ", " << builder);
            check_all(build(mesh, builder), mesh, rays);
        }
    }
}

TEST_CASE("rays through vertices and edges find together what each finds alone") {
    // Vertices with whole coordinates, and slopes that are multiples of 1/64: edge functions are exactly 0.
    Mesh mesh;
    constexpr std::uint32_t side = 16;
    for (std::uint32_t y = 0; y <= side; ++y) {
        for (std::uint32_t x = 0; x <= side; ++x)
            mesh.vertices.push_back({static_cast<float>(x), static_cast<float>(y), 8.0f});
    }
    for (std::uint32_t y = 0; y < side; ++y) {
        for (std::uint32_t x = 0; x < side; ++x) {
            const std::uint32_t corner = y * (side + 1) + x;
            mesh.triangles.push_back({corner, corner + 1, corner + side + 2});
            mesh.triangles.push_back({corner, corner + side + 2, corner + side + 1});
        }
    }
    std::vector<Ray> rays;
    for (std::uint32_t y = 1; y < 64; ++y) {
        for (std::uint32_t x = 1; x <= 64; ++x)
            rays.push_back({{0, 0, 0}, 0.0f, {static_cast<float>(x) / 64, static_cast<float>(y) / 64, 1.0f}});
    }
    const Bvh bvh = build(mesh, "binned-sah");
    check_all(bvh, mesh, rays);
    std::vector<Hit> hits(rays.size());
    Tracer(bvh, mesh).closest(rays, hits);
    CHECK(std::ranges::all_of(hits, [](const Hit& hit) { return hit.t == 8.0f; }));
}

TEST_CASE("any number of rays is traced as one by one, with and without a filter") {
    const Mesh mesh = generate_scene("hair", 3000);
    const Tracer tracer(build(mesh, "binned-sah"), mesh, {.thread_count = 2});
    const auto is_solid = [](const Ray&, const Hit& hit) { return hit.primitive % 3 != 0; };
    const Aabb box = mesh_bounds(mesh);
    std::vector<Ray> all = scattered_rays(box, 32);
    for (const std::vector<Ray>& more : {camera_rays(box, 28), with_odd_ones(scattered_rays(box, 1300))})
        all.insert(all.end(), more.begin(), more.end());
    for (const std::size_t count : {0u, 1u, 7u, 8u, 9u, 31u, 32u, 33u, 255u, 816u, 1023u, 1024u, 1025u, 2116u}) {
        const std::span<const Ray> rays = std::span(all).first(count);
        std::vector<Hit> hits(count), solid_hits(count);
        std::vector<std::uint8_t> any(count, 9), any_solid(count, 9);
        tracer.closest(rays, hits);
        tracer.any(rays, any);
        tracer.closest(rays, solid_hits, is_solid);
        tracer.any(rays, any_solid, is_solid);
        std::size_t differences = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const bool agrees = same_bits(hits[i], tracer.closest(rays[i])) &&
                                any[i] == (tracer.any(rays[i]) ? 1 : 0) &&
                                same_bits(solid_hits[i], tracer.closest(rays[i], is_solid)) &&
                                any_solid[i] == (tracer.any(rays[i], is_solid) ? 1 : 0);
            if (!agrees) ++differences;
        }
        INFO(count << " rays");
        CHECK(differences == 0);
    }
}
