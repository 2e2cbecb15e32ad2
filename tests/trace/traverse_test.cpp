#include "clbvh/trace/traverse.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <optional>
#include <vector>

#include "clbvh/host/sweep_sah.hpp"
#include "core/random.hpp"

using namespace clbvh;

namespace {

/// Primitives of a caller's own.
struct Sphere {
    Vec3 centre;
    float radius;

    [[nodiscard]] Aabb bounds() const {
        const Vec3& c = centre;
        return {{c.x - radius, c.y - radius, c.z - radius}, {c.x + radius, c.y + radius, c.z + radius}};
    }
    /// Where the ray enters the sphere, if it does so between t_min and t_max.
    [[nodiscard]] std::optional<float> enter(const Ray& ray, float t_max) const {
        const Vec3 o{ray.origin.x - centre.x, ray.origin.y - centre.y, ray.origin.z - centre.z};
        const Vec3& d = ray.direction;
        const float a = d.x * d.x + d.y * d.y + d.z * d.z;
        const float b = o.x * d.x + o.y * d.y + o.z * d.z;
        const float discriminant = b * b - a * (o.x * o.x + o.y * o.y + o.z * o.z - radius * radius);
        if (!(discriminant >= 0.0f)) return std::nullopt;
        const float t = (-b - std::sqrt(discriminant)) / a;
        if (t >= ray.t_min && t <= t_max) return t;
        return std::nullopt;
    }
};

struct Scene {
    std::vector<Sphere> spheres;
    Bvh bvh;
    std::vector<Ray> rays;

    Scene() {
        Random random(5);
        std::vector<Aabb> boxes;
        for (int i = 0; i < 3000; ++i) {
            spheres.push_back({random.in_cube(-10.0f, 10.0f), random.between(0.05f, 0.8f)});
            boxes.push_back(spheres.back().bounds());
        }
        bvh = build_sweep_sah(boxes);
        for (int i = 0; i < 3000; ++i)
            rays.push_back(
                {random.in_cube(-12.0f, 12.0f), 0.0f, random.in_cube(-1.0f, 1.0f), random.between(1.0f, 40.0f)});
    }
};

/// The closest of all, by t alone.
float closest_without_tree(const Scene& scene, const Ray& ray) {
    float closest = INFINITY;
    for (const Sphere& sphere : scene.spheres) {
        if (const auto t = sphere.enter(ray, std::min(closest, ray.t_max))) closest = *t;
    }
    return closest;
}

}  // namespace

TEST_CASE("a traversal finds the closest of primitives of the caller's own") {
    const Scene scene;
    std::size_t differences = 0, hits = 0, tested = 0;
    for (const Ray& ray : scene.rays) {
        float closest = INFINITY;
        traverse(scene.bvh.nodes, ray, [&](std::uint32_t first, std::uint32_t count, float& t_max) {
            for (std::uint32_t i = first; i < first + count; ++i) {
                ++tested;
                if (const auto t = scene.spheres[scene.bvh.primitive_ids[i]].enter(ray, t_max)) closest = t_max = *t;
            }
            return true;
        });
        differences += closest == closest_without_tree(scene, ray) ? 0 : 1;
        hits += std::isfinite(closest) ? 1 : 0;
    }
    CHECK(differences == 0);
    CHECK(hits > scene.rays.size() / 4);
    CHECK(tested < scene.rays.size() * scene.spheres.size() / 50);
}

TEST_CASE("a traversal ends where its caller says so, and counts what it visited") {
    const Scene scene;
    std::size_t differences = 0;
    for (const Ray& ray : scene.rays) {
        bool is_hit = false;
        RayCounts any_counts, all_counts;
        std::uint32_t leaves = 0;
        traverse(
            scene.bvh.nodes, ray,
            [&](std::uint32_t first, std::uint32_t count, float& t_max) {
                ++leaves;
                for (std::uint32_t i = first; i < first + count && !is_hit; ++i)
                    is_hit = scene.spheres[scene.bvh.primitive_ids[i]].enter(ray, t_max).has_value();
                return !is_hit;
            },
            any_counts);
        traverse(
            scene.bvh.nodes, ray, [](std::uint32_t, std::uint32_t, float&) { return true; }, all_counts);
        const bool agrees = is_hit == std::isfinite(closest_without_tree(scene, ray)) && any_counts.leaves == leaves &&
                            any_counts.leaves <= all_counts.leaves &&
                            any_counts.inner_nodes <= all_counts.inner_nodes && any_counts.triangles == 0;
        differences += agrees ? 0 : 1;
    }
    CHECK(differences == 0);
}

TEST_CASE("no leaf of no tree is visited") {
    traverse(std::span<const Node>{}, {{0, 0, 0}, 0.0f, {1, 0, 0}}, [](std::uint32_t, std::uint32_t, float&) {
        FAIL("visited");
        return true;
    });
}
