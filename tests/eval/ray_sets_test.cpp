#include "clbvh/eval/ray_sets.hpp"

#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "clbvh/builder.hpp"
#include "clbvh/core/mesh_bounds.hpp"
#include "clbvh/core/vector.hpp"
#include "clbvh/eval/surface.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/sah.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"
#include "trace/brute_force.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr Camera kLooksDown{{0, 3, 0.01f}, {0, 0, 0}, {0, 1, 0}, 60.0f};
constexpr Aabb kRoom{{-1, 0, -2}, {2, 3, 1}};
constexpr Camera kInRoom{{0.5f, 1.5f, 0.9f}, {0, 1, -1}, {0, 1, 0}, 70.0f};

/// Mean of `value` over the items.
template <typename Items, typename Value>
double mean(const Items& items, const Value& value) {
    double sum = 0.0;
    for (const auto& item : items)
        sum += value(item);
    return sum / static_cast<double>(items.size());
}

/// The part of the line through the ray that lies in the box: its length, 0 where there is none.
double chord(const Ray& ray, const Aabb& box) {
    const std::array<double, 3> origin{ray.origin.x, ray.origin.y, ray.origin.z};
    const std::array<double, 3> direction{ray.direction.x, ray.direction.y, ray.direction.z};
    const std::array<double, 3> lower{box.lower.x, box.lower.y, box.lower.z};
    const std::array<double, 3> upper{box.upper.x, box.upper.y, box.upper.z};
    double begin = -1e300;
    double end = 1e300;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double a = (lower[axis] - origin[axis]) / direction[axis];
        const double b = (upper[axis] - origin[axis]) / direction[axis];
        begin = std::max(begin, std::min(a, b));
        end = std::min(end, std::max(a, b));
    }
    return end - begin;
}

/// Cost of a line that visits every node whose box, and whose ancestors' boxes, it crosses.
double cost_of_line(const Bvh& bvh, const Ray& ray, const SahCosts& costs) {
    double cost = 0.0;
    std::vector<std::uint32_t> open{0};
    while (!open.empty()) {
        const Node& node = bvh.nodes[open.back()];
        open.pop_back();
        if (chord(ray, node.bounds()) < 0.0) continue;
        cost += node.is_leaf() ? costs.primitive * node.count : costs.inner;
        if (node.is_leaf()) continue;
        open.push_back(node.first);
        open.push_back(node.first + 1);
    }
    return cost;
}

}  // namespace

TEST_CASE("random lines have the mean chord of isotropic lines through a box") {
    // Cauchy: four times the volume over the surface.
    for (const Aabb& box : {Aabb{{0, 0, 0}, {1, 1, 1}}, Aabb{{-3, 5, 1}, {1, 6, 9}}, Aabb{{0, 0, 0}, {10, 0.1f, 3}}}) {
        const Vec3 size = box.upper - box.lower;
        const double expected = 2.0 * size.x * size.y * size.z / half_area(box);
        const std::vector<Ray> lines = random_lines(box, 200000, 3);
        REQUIRE(lines.size() == 200000);
        CHECK(mean(lines, [&](const Ray& ray) { return std::max(0.0, chord(ray, box)); }) ==
              Approx(expected).epsilon(0.02));
        // Rounding may make a line miss that enters next to an edge.
        CHECK(std::ranges::count_if(lines, [&](const Ray& ray) { return chord(ray, box) <= 0.0; }) < 20);
        CHECK(mean(lines, [](const Ray& ray) { return length(ray.direction); }) == Approx(1.0));
    }
    CHECK(random_lines({{0, 0, 0}, {1, 1, 0}}, 10, 1).size() == 10);
    CHECK(random_lines({{0, 0, 0}, {1, 0, 0}}, 10, 1).empty());
    CHECK(random_lines({{1, 1, 1}, {1, 1, 1}}, 10, 1).empty());
}

TEST_CASE("random lines cost what the surface area heuristic says") {
    for (const char* scene : {"gen:soup:2000", "gen:city:2000", "gen:hair:2000"}) {
        const Mesh mesh = load_scene(scene);
        const std::vector<Ray> lines = random_lines(mesh_bounds(mesh), 20000, 7);
        for (const char* builder : {"binned-sah", "median", "aac-hq"}) {
            INFO(scene << ", " << builder);
            const Bvh bvh = Builder(builder).build(mesh);
            const SahCosts costs;
            const double cost = mean(lines, [&](const Ray& ray) { return cost_of_line(bvh, ray, costs); });
            const double square =
                mean(lines, [&](const Ray& ray) { return std::pow(cost_of_line(bvh, ray, costs), 2.0); });
            const double error = std::sqrt((square - cost * cost) / static_cast<double>(lines.size()));
            CHECK(std::abs(cost - sah_cost(bvh)) < 4.0 * error);
            CHECK(error < 0.02 * cost);
        }
    }
}

TEST_CASE("primary rays go through their cells") {
    constexpr std::uint32_t width = 8;
    constexpr std::uint32_t height = 6;
    const std::vector<Ray> rays = primary_rays(kInRoom, width, height, 5);
    REQUIRE(rays.size() == width * height);
    const CameraRays camera(kInRoom, 8.0f / 6.0f);
    for (std::uint32_t i = 0; i < rays.size(); ++i) {
        const auto x = static_cast<float>(i % width);
        const auto y = static_cast<float>(i / width);
        CHECK(rays[i].origin == kInRoom.eye);
        // The planes through the eye and the cell's edges have the ray between them.
        const auto corner = [&](float dx, float dy) {
            return camera.at((x + dx) / width, (y + dy) / height).direction;
        };
        const auto side = [&](const Vec3& a, const Vec3& b) { return dot(cross(a, b), rays[i].direction); };
        CHECK(side(corner(0, 0), corner(1, 0)) * side(corner(0, 1), corner(1, 1)) <= 1e-9f);
        CHECK(side(corner(0, 0), corner(0, 1)) * side(corner(1, 0), corner(1, 1)) <= 1e-9f);
    }
}

TEST_CASE("diffuse rays are distributed as the cosine") {
    const Mesh ground = ground_mesh(10.0f);
    const std::vector<Ray> primary = primary_rays(kLooksDown, 20, 20, 1);
    const std::vector<Ray> rays = diffuse_rays(ground, brute_force(ground), primary, 64, 1);
    REQUIRE(rays.size() == 400 * 64);
    const auto moment = [&](const auto& value) { return mean(rays, value); };
    const double error = 4.0 / std::sqrt(static_cast<double>(rays.size()));
    CHECK(moment([](const Ray& r) { return r.direction.y; }) == Approx(2.0 / 3.0).margin(error));
    CHECK(moment([](const Ray& r) { return r.direction.y * r.direction.y; }) == Approx(0.5).margin(error));
    CHECK(moment([](const Ray& r) { return r.direction.x; }) == Approx(0.0).margin(error));
    CHECK(moment([](const Ray& r) { return r.direction.z; }) == Approx(0.0).margin(error));
    CHECK(moment([](const Ray& r) { return r.direction.x * r.direction.x; }) == Approx(0.25).margin(error));
    CHECK(moment([](const Ray& r) { return r.direction.x * r.direction.z; }) == Approx(0.0).margin(error));
    CHECK(std::ranges::all_of(rays, [](const Ray& r) { return r.origin.y > 0.0f && r.origin.y < 1e-3f; }));
    CHECK(std::ranges::all_of(rays, [](const Ray& r) { return std::isinf(r.t_max) && r.t_min == 0.0f; }));
}

TEST_CASE("in a closed room every diffuse ray has a successor") {
    const Mesh room = box_mesh(kRoom);
    const ClosestHits trace = brute_force(room);
    const std::vector<Ray> primary = primary_rays(kInRoom, 10, 10, 1);
    const std::vector<Ray> rays = diffuse_rays(room, trace, primary, 8, 1);
    CHECK(rays.size() == 2 * 800);
    for (const Ray& ray : rays) {
        CHECK(chord({ray.origin, 0.0f, {0.3f, 0.5f, 0.7f}}, kRoom) > 0.0);
        const Vec3 to_lower = ray.origin - kRoom.lower;
        const Vec3 to_upper = kRoom.upper - ray.origin;
        const float nearest = std::min({to_lower.x, to_lower.y, to_lower.z, to_upper.x, to_upper.y, to_upper.z});
        CHECK(nearest > 0.0f);
        CHECK(nearest < 1e-4f);
    }
    // The rays of the second bounce begin where those of the first end.
    std::vector<Hit> hits(rays.size());
    trace(rays, hits);
    for (std::size_t i = 0; i < 800; ++i)
        CHECK(length(surface_point(room, rays[i], hits[i]).position - rays[800 + i].origin) < 1e-5f);
}

TEST_CASE("rays from a surface do not meet it again") {
    for (const float scale : {1e-12f, 1.0f, 1e6f, 1e12f}) {
        Mesh mesh = scaled(random_triangles(300), scale);
        for (Vec3& vertex : mesh.vertices)
            vertex = vertex + Vec3{30.0f * scale, -7.0f * scale, 100.0f * scale};
        const Aabb box = mesh_bounds(mesh);
        const std::vector<Ray> lines = random_lines(box, 4000, 9);
        std::vector<Hit> hits(lines.size());
        brute_force(mesh)(lines, hits);
        std::size_t found = 0;
        for (std::size_t i = 0; i < lines.size(); ++i) {
            if (!hits[i]) continue;
            ++found;
            const Mesh alone{mesh.vertices, {mesh.triangles[hits[i].primitive]}};
            const SurfacePoint point = surface_point(mesh, lines[i], hits[i]);
            CHECK(length(point.normal) == Approx(1.0));
            CHECK(dot(point.normal, lines[i].direction) <= 0.0f);
            Ray away;
            away.origin = point.position;
            away.direction = cosine_direction(point.normal, 0.6f, -0.799f);
            Hit again;
            brute_force(alone)({&away, 1}, {&again, 1});
            CHECK(!again);
        }
        CHECK(found > 100);
    }
}

TEST_CASE("shadow rays end at lights before the surface") {
    const Mesh ground = ground_mesh(10.0f);
    const std::vector<Ray> primary = primary_rays(kLooksDown, 4, 3, 1);
    const std::array<Vec3, 3> lights{{{1, 2, 3}, {0, -1, 0}, {-4, 0.5f, 0}}};
    const std::vector<Ray> rays = shadow_rays(ground, brute_force(ground), primary, lights);
    REQUIRE(rays.size() == 24);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        CHECK(length(rays[i].origin + rays[i].direction - lights[i % 2 == 0 ? 0 : 2]) < 1e-5f);
        CHECK(rays[i].t_max == 1.0f);
    }
}

TEST_CASE("lights are in the box, or around it where the camera is outside") {
    const auto inside = [](const std::vector<Vec3>& lights, const Aabb& box) {
        return std::ranges::all_of(lights, [&](const Vec3& p) { return merge(box, p) == box; });
    };
    CHECK(inside(random_lights(kRoom, kInRoom, 1000, 1), kRoom));
    const Camera outside{{9, 9, 9}, {0, 0, 0}};
    CHECK(!inside(random_lights(kRoom, outside, 1000, 1), kRoom));
    CHECK(inside(random_lights(kRoom, outside, 1000, 1), {{-4, -3, -5}, {5, 6, 4}}));
}

TEST_CASE("rays of ambient occlusion are short") {
    const Mesh room = box_mesh(kRoom);
    const std::vector<Ray> rays = make_rays(RayKind::ambient_occlusion, room, brute_force(room), kInRoom, {3200, 1});
    CHECK(rays.size() == Approx(3200).epsilon(0.1));
    const float tenth = 0.1f * length(kRoom.upper - kRoom.lower);
    CHECK(std::ranges::all_of(rays, [&](const Ray& ray) { return ray.t_max == tenth; }));
}

TEST_CASE("sets have about as many rays as wanted, and depend on nothing but the arguments") {
    const Mesh room = box_mesh(kRoom);
    const ClosestHits trace = brute_force(room);
    for (const RayKind kind :
         {RayKind::primary, RayKind::diffuse, RayKind::shadow, RayKind::ambient_occlusion, RayKind::random}) {
        INFO(to_string(kind));
        CHECK(ray_kind_from(to_string(kind)) == kind);
        const auto rays = [&](std::uint64_t seed) { return make_rays(kind, room, trace, kInRoom, {20000, seed}); };
        const std::vector<Ray> first = rays(1);
        CHECK(static_cast<double>(first.size()) == Approx(20000).epsilon(0.1));
        CHECK(rays(1) == first);
        CHECK(rays(2) != first);
        const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
        CHECK(rays(1) == first);
    }
    CHECK(!ray_kind_from("mirror"));
}

TEST_CASE("sets of rays from what a camera sees are empty where it sees nothing") {
    const Mesh room = box_mesh(kRoom);
    const Camera away{{9, 0, 0}, {10, 0, 0}};
    for (const RayKind kind : {RayKind::diffuse, RayKind::shadow, RayKind::ambient_occlusion})
        CHECK(make_rays(kind, room, brute_force(room), away, {}).empty());
    const Mesh nothing;
    CHECK(make_rays(RayKind::random, nothing, brute_force(nothing), kInRoom, {}).empty());
    CHECK(make_rays(RayKind::diffuse, nothing, brute_force(nothing), kInRoom, {}).empty());
}

TEST_CASE("a set of no rays, or of too many, is refused") {
    const Mesh room = box_mesh(kRoom);
    for (const std::uint64_t count : {std::uint64_t{0}, (std::uint64_t{1} << 30) + 1}) {
        expect_error(ErrorCode::invalid_input, {std::to_string(count), "1 to 1073741824"}, [&] {
            static_cast<void>(make_rays(RayKind::random, room, brute_force(room), kInRoom, {count, 1}));
        });
    }
}
