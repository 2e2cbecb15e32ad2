// No ray leaves a closed mesh, wherever on it the ray is aimed.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <utility>

#include "clbvh/builder.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/trace/tracer.hpp"
#include "core/random.hpp"

using namespace clbvh;

namespace {

/// Corners at one place become one vertex.
Mesh weld(const Mesh& mesh) {
    Mesh welded;
    std::map<std::array<float, 3>, std::uint32_t> places;
    for (Triangle triangle : mesh.triangles) {
        for (std::uint32_t& corner : triangle) {
            const Vec3& v = mesh.vertices[corner];
            const auto [place, is_new] =
                places.try_emplace({v.x, v.y, v.z}, static_cast<std::uint32_t>(welded.vertices.size()));
            if (is_new) welded.vertices.push_back(v);
            corner = place->second;
        }
        if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0])
            welded.triangles.push_back(triangle);
    }
    return welded;
}

/// True where every edge is passed as often in one direction as in the other.
bool is_closed(const Mesh& mesh) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> balance;
    for (const Triangle& triangle : mesh.triangles) {
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t from = triangle[i], to = triangle[(i + 1) % 3];
            balance[{std::min(from, to), std::max(from, to)}] += from < to ? 1 : -1;
        }
    }
    return std::ranges::all_of(balance, [](const auto& edge) { return edge.second == 0; });
}

/// Whether a point is inside the closed mesh: lines through it cross the surface an odd number of times on either side.
/// Only points for which three lines agree count.
bool is_inside(const Tracer& tracer, const Vec3& point) {
    for (const Vec3& direction : {Vec3{0.31f, 0.59f, 0.74f}, Vec3{-0.67f, 0.21f, -0.35f}, Vec3{0.13f, -0.83f, 0.41f}}) {
        std::size_t crossings = 0;
        tracer.all({point, 0.0f, direction}, [&](const Hit&) { return ++crossings > 0; });
        if (crossings % 2 == 0) return false;
    }
    return true;
}

/// Points within the mesh, away from its surface.
std::vector<Vec3> inner_points(const Tracer& tracer, const Aabb& box, std::size_t count, Random& random) {
    std::vector<Vec3> points;
    while (points.size() < count) {
        const Vec3 w = random.in_cube(0.0f, 1.0f);
        const Vec3 point{box.lower.x + w.x * (box.upper.x - box.lower.x),
                         box.lower.y + w.y * (box.upper.y - box.lower.y),
                         box.lower.z + w.z * (box.upper.z - box.lower.z)};
        if (is_inside(tracer, point)) points.push_back(point);
    }
    return points;
}

Vec3 target_on(const Mesh& mesh, const Triangle& triangle, std::uint32_t kind, Random& random) {
    const Vec3 &a = mesh.vertices[triangle[0]], &b = mesh.vertices[triangle[1]], &c = mesh.vertices[triangle[2]];
    if (kind == 0) return a;
    const float s = kind == 1 ? 0.5f : random.unit();
    const Vec3 edge{a.x + s * (b.x - a.x), a.y + s * (b.y - a.y), a.z + s * (b.z - a.z)};
    if (kind != 3) return edge;
    const float t = random.unit();
    return {edge.x + t * (c.x - edge.x), edge.y + t * (c.y - edge.y), edge.z + t * (c.z - edge.z)};
}

/// How many of `count` rays from inside leave the mesh unhindered: a quarter each is aimed at vertices, middles of
/// edges, points of edges, and points of faces; every eighth runs along an axis instead.
std::size_t count_escapes(const Mesh& mesh, const char* builder, std::size_t count) {
    const Bvh bvh = build(mesh, builder);
    const Tracer tracer(bvh, mesh);
    Random random(3);
    const std::vector<Vec3> origins = inner_points(tracer, bvh.nodes[0].bounds(), 200, random);
    std::size_t escapes = 0;
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    while (count > 0) {
        rays.clear();
        for (; rays.size() < 100000 && count > 0; --count) {
            const Vec3& origin = origins[random.below(static_cast<std::uint32_t>(origins.size()))];
            const Triangle& triangle = mesh.triangles[random.below(static_cast<std::uint32_t>(mesh.triangles.size()))];
            const Vec3 to = target_on(mesh, triangle, static_cast<std::uint32_t>(count % 4), random);
            Vec3 direction{to.x - origin.x, to.y - origin.y, to.z - origin.z};
            Vec3 from = origin;
            if (count / 4 % 8 == 7) {
                // Through the target as exactly as floats can say, if the line begins inside.
                direction = {0.0f, -0.0f, random.below(2) == 0 ? 1.0f : -1.0f};
                from = {to.x, to.y, origin.z};
                if (!is_inside(tracer, from)) continue;
            }
            rays.push_back({from, 0.0f, direction});
        }
        hits.resize(rays.size());
        tracer.closest(rays, hits);
        escapes += static_cast<std::size_t>(std::ranges::count(hits, false, [](const Hit& hit) { return bool(hit); }));
    }
    return escapes;
}

/// CLBVH_ESCAPE_RAYS overrides the number for a long run by hand.
std::size_t ray_count(std::size_t usual) {
    const char* const wanted = std::getenv("CLBVH_ESCAPE_RAYS");
    return wanted == nullptr ? usual : std::strtoull(wanted, nullptr, 10);
}

}  // namespace

TEST_CASE("no ray escapes from a sphere") {
    const Mesh mesh = weld(generate_scene("sphere", 20000));
    REQUIRE(is_closed(mesh));
    for (const char* builder : {"binned-sah", "sbvh"}) {
        INFO(builder);
        CHECK(count_escapes(mesh, builder, ray_count(500000)) == 0);
    }
}

TEST_CASE("no ray escapes from the bunny") {
    const char* const folder = std::getenv("CLBVH_SCENES");
    if (folder == nullptr || !std::filesystem::exists(std::filesystem::path(folder) / "bunny.ply")) {
        WARN("SKIPPED: CLBVH_SCENES names no folder with bunny.ply");
        return;
    }
    const Mesh mesh = weld(load_scene((std::filesystem::path(folder) / "bunny.ply").string()));
    REQUIRE(is_closed(mesh));
    CHECK(count_escapes(mesh, "binned-sah", ray_count(500000)) == 0);
}
