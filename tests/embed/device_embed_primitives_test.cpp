#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <optional>
#include <vector>

#include "clbvh/builder.hpp"
#include "embed/embedded_kernels.hpp"
#include "support/found_rays.hpp"
#include "support/oracle/ray_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

/// x y z and radius.
using Sphere = std::array<float, 4>;

std::vector<Sphere> some_spheres(std::size_t count) {
    std::uint32_t state = 1;
    const auto next = [&] {
        state = state * 1664525U + 1013904223U;
        return static_cast<float>(state >> 8U) * 0x1p-24f;
    };
    std::vector<Sphere> spheres(count);
    for (Sphere& sphere : spheres)
        sphere = {next(), next(), next(), 0.01f + 0.1f * next() * next()};
    return spheres;
}

/// Triangles whose boxes are those around the spheres, and a little larger, since the hits are rounded.
Mesh boxes_of(const std::vector<Sphere>& spheres) {
    Mesh mesh;
    for (const auto& [x, y, z, radius] : spheres) {
        const float r = 1.05f * radius;
        const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.insert(mesh.vertices.end(), {{x - r, y - r, z - r}, {x + r, y + r, z + r}, {x - r, y + r, z}});
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
}

float dot_of(const Vec3& a, const Vec3& b) {
    return (a.x * b.x + a.y * b.y) + a.z * b.z;
}

/// Where the ray's line enters and leaves the sphere: as in the kernels, to the bit.
std::optional<std::array<float, 2>> roots(const Sphere& sphere, const Ray& ray) {
    const Vec3 from{ray.origin.x - sphere[0], ray.origin.y - sphere[1], ray.origin.z - sphere[2]};
    const float a = dot_of(ray.direction, ray.direction), b = dot_of(from, ray.direction);
    const float squared = b * b - a * (dot_of(from, from) - sphere[3] * sphere[3]);
    if (!(squared >= 0.0f)) return std::nullopt;
    const float root = std::sqrt(squared);
    return std::array{(-b - root) / a, (-b + root) / a};
}

/// All hits in order, without a tree. Each `period`-th is a hole; 0: none.
std::vector<Hit> all_hits(const std::vector<Sphere>& spheres, const Ray& ray, std::uint32_t period) {
    std::vector<Hit> hits;
    if (hits_nothing(ray)) return hits;
    for (std::uint32_t i = 0; i < spheres.size(); ++i) {
        const auto ts = roots(spheres[i], ray);
        for (std::uint32_t side = 0; ts && side < 2; ++side) {
            const Hit hit{(*ts)[side], 0.0f, 0.0f, 2 * i + side};
            const bool is_in_range = std::max(ray.t_min, 0.0f) <= hit.t && hit.t <= ray.t_max;
            if (is_in_range && (period == 0 || hit.primitive % period != 0)) hits.push_back(hit);
        }
    }
    std::ranges::sort(hits,
                      [](const Hit& a, const Hit& b) { return a.t != b.t ? a.t < b.t : a.primitive < b.primitive; });
    return hits;
}

/// Each `period`-th hit is a hole; 0: none.
void check_spheres(std::uint32_t period) {
    if (!device_is_exact()) {
        WARN("SKIPPED: the device does not round as the host does, so bits go unchecked");
        return;
    }
    const std::vector<Sphere> spheres = some_spheres(400);
    const Mesh mesh = boxes_of(spheres);
    User user{{static_cast<float>(period)}};
    user.insert(user.end(), spheres.begin(), spheres.end());
    std::vector<Ray> rays = difficult_rays(mesh, 100);
    for (const Ray& ray : untraceable_rays())
        rays.push_back(ray);

    Embedded expected;
    std::size_t most = 0;
    for (const Ray& ray : rays) {
        const std::vector<Hit> hits = all_hits(spheres, ray, period);
        most = std::max(most, hits.size());
        expected.closest.push_back(hits.empty() ? Hit{} : hits.front());
        expected.any.push_back(hits.empty() ? 0 : 1);
        AllHits& all = expected.all.emplace_back();
        for (const Hit& hit : hits)
            all.add(hit);
    }
    CHECK(most > 8);  // more than clbvh_all is asked for at once
    for (const EmbeddedScene& scene : embedded_scenes(build(mesh, "binned-sah"), mesh)) {
        INFO(scene.layout());
        const Embedded found = scene.trace(
            "-DCLBVH_INTERSECT_PRIMITIVE=hit_sphere -DCLBVH_ACCEPT_HIT=is_solid -DCLBVH_STACK=20", rays, user);
        CHECK(count_differences(found.closest, expected.closest) == 0);
        CHECK(count_differences(found.any, expected.any) == 0);
        CHECK(count_differences(found.all, expected.all) == 0);
    }
}

}  // namespace

TEST_CASE("embedded: primitives of one's own are hit as without a tree, and as often as the ray meets them") {
    check_spheres(0);
}

TEST_CASE("embedded: behind a hole in a primitive of one's own there may be its other side") {
    check_spheres(3);
}
