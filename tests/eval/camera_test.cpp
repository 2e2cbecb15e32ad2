#include "clbvh/eval/camera.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "clbvh/builder.hpp"
#include "clbvh/core/mesh_bounds.hpp"
#include "clbvh/core/vector.hpp"
#include "clbvh/eval/ray_sets.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/trace/tracer.hpp"
#include "support/expect_error.hpp"
#include "trace/brute_force.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr Vec3 kUp{0, 1, 0};

void check_close(const Vec3& a, const Vec3& b) {
    INFO(a.x << " " << a.y << " " << a.z << " and " << b.x << " " << b.y << " " << b.z);
    CHECK(length(a - b) < 1e-5f);
}

}  // namespace

TEST_CASE("a camera's picture has its target in the middle and its edges at the field of view") {
    const CameraRays rays({{1, 2, 3}, {1, 2, -1}, kUp, 90.0f}, 2.0f);
    CHECK(rays.at(0.5f, 0.5f).origin == Vec3{1, 2, 3});
    check_close(rays.at(0.5f, 0.5f).direction, {0, 0, -1});
    check_close(rays.at(0.5f, 0.0f).direction, normalized({0, 1, -1}));
    check_close(rays.at(0.5f, 1.0f).direction, normalized({0, -1, -1}));
    check_close(rays.at(0.0f, 0.5f).direction, normalized({-2, 0, -1}));
    check_close(rays.at(1.0f, 1.0f).direction, normalized({2, -1, -1}));
}

TEST_CASE("the field of view is the angle asked for") {
    for (const float degrees : {1.0f, 35.0f, 60.0f, 120.0f, 170.0f}) {
        const Ray top = CameraRays({{0, 0, 0}, {0, 0, -1}, kUp, degrees}, 1.0f).at(0.5f, 0.0f);
        const double angle = 2.0 * std::atan2(top.direction.y, -top.direction.z) * 180.0 / std::acos(-1.0);
        CHECK(angle == Approx(degrees).epsilon(1e-6));
    }
}

TEST_CASE("a camera that looks straight up or down has a picture all the same") {
    for (const Vec3 target : {Vec3{0, 5, 0}, Vec3{0, -5, 0}}) {
        const CameraRays rays({{0, 0, 0}, target, kUp, 60.0f}, 1.0f);
        check_close(rays.at(0.5f, 0.5f).direction, normalized(target));
        CHECK(length(rays.at(0.0f, 0.5f).direction - rays.at(1.0f, 0.5f).direction) > 0.5f);
    }
    const CameraRays without_up({{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, 60.0f}, 1.0f);
    CHECK(length(without_up.at(0.0f, 0.5f).direction) == Approx(1.0));
}

TEST_CASE("cameras that see nothing are refused") {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float infinity = std::numeric_limits<float>::infinity();
    const auto refuse = [](const std::string& part, const Camera& camera, float aspect = 1.0f) {
        expect_error(ErrorCode::invalid_input, {part}, [&] { (void)CameraRays(camera, aspect); });
    };
    refuse("not finite", {{nan, 0, 0}, {0, 0, 1}});
    refuse("not finite", {{0, 0, 0}, {0, infinity, 1}});
    refuse("target is at its eye", {{1, 2, 3}, {1, 2, 3}});
    for (const float degrees : {0.0f, -30.0f, 171.0f, nan})
        refuse("1 to 170", {{0, 0, 0}, {1, 0, 0}, kUp, degrees});
    for (const float aspect : {0.0f, -1.0f, nan, infinity})
        refuse("width over its height", {{0, 0, 0}, {1, 0, 0}, kUp, 40.0f}, aspect);
}

TEST_CASE("cameras are read as they are written") {
    const Camera camera{{0.1f, -2.5e-7f, 3e9f}, {1.0f / 3.0f, 7, 8}, {0, 0, 1}, 41.3f};
    CHECK(parse_camera(to_string(camera), {0, 0, 1}) == camera);
    CHECK(parse_camera("1,2,3,4,5,6", kUp) == Camera{{1, 2, 3}, {4, 5, 6}, kUp, 45.0f});
    for (const std::string text : {"", "1,2,3", "1,2,3,4,5,6,7,8", "1,2,3,4,5,six", "1,2,3,4,5,6,", "1 2 3 4 5 6"})
        expect_error(ErrorCode::invalid_input, {'"' + text + '"'}, [&] { (void)parse_camera(text, kUp); });
    expect_error(ErrorCode::invalid_input, {"1 to 170"}, [] { (void)parse_camera("1,2,3,4,5,6,0", kUp); });
    expect_error(ErrorCode::invalid_input, {"not finite"}, [] { (void)parse_camera("1,2,nan,4,5,6", kUp); });
}

TEST_CASE("axes have names") {
    CHECK(parse_axis("x") == Vec3{1, 0, 0});
    CHECK(parse_axis("-z") == Vec3{0, 0, -1});
    for (const std::string text : {"", "-", "w", "--y", "yz"})
        expect_error(ErrorCode::invalid_input, {'"' + text + '"', "-x"}, [&] { (void)parse_axis(text); });
}

TEST_CASE("the floor tells what is up") {
    Mesh ground = ground_mesh(3.0f);
    CHECK(guess_up(ground) == kUp);
    for (Vec3& vertex : ground.vertices)
        std::swap(vertex.y, vertex.z);
    CHECK(guess_up(ground) == Vec3{0, 0, 1});
    CHECK(guess_up(generate_scene("sphere", 2000)) == kUp);
    CHECK(guess_up({}) == kUp);
}

TEST_CASE("a room is seen from inside and an object from outside") {
    const Aabb box{{-5, 0, -3}, {4, 3, 4}};
    const Mesh room = box_mesh(box);
    const Camera inside = fit_camera(room, kUp, brute_force(room));
    CHECK(merge(box, inside.eye) == box);
    const Mesh ball = generate_scene("sphere", 500);
    const Camera outside = fit_camera(ball, kUp, brute_force(ball));
    CHECK(merge(mesh_bounds(ball), outside.eye) != mesh_bounds(ball));
    CHECK(outside.eye.y > outside.target.y);
    CHECK(fit_camera(ball, kUp, brute_force(ball)) == outside);
}

TEST_CASE("an object fits into the picture from outside") {
    for (const Vec3 up : {Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{-1, 0, 0}}) {
        const Mesh ball = generate_scene("sphere", 500);
        const Camera camera = fit_camera(ball, up, brute_force(ball));
        const CameraRays rays(camera, 4.0f / 3.0f);
        const Vec3 ahead = rays.at(0.5f, 0.5f).direction;
        const float least = dot(ahead, rays.at(0.5f, 0.0f).direction);
        for (const Vec3& vertex : ball.vertices)
            CHECK(dot(normalized(vertex - camera.eye), ahead) > least);
    }
}

TEST_CASE("one triangle and one wall have cameras that see them") {
    Mesh triangle;
    triangle.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
    triangle.triangles = {{0, 1, 2}};
    Mesh wall = triangle;
    wall.triangles.push_back({1, 3, 2});
    for (const Mesh& mesh : {triangle, wall}) {
        const Bvh bvh = build(mesh, "median");
        const Tracer tracer(bvh, mesh);
        const Camera camera = fit_camera(mesh, {0, 1, 0}, closest_hits_of(tracer));
        const std::vector<Ray> rays = primary_rays(camera, 32, 24, 1);
        CHECK(std::ranges::any_of(rays, [&](const Ray& ray) { return tracer.any(ray); }));
    }
}

TEST_CASE("scenes of nothing, of a point and far away have cameras") {
    const Mesh empty;
    static_cast<void>(CameraRays(fit_camera(empty, kUp, brute_force(empty)), 1.0f));
    for (const float at : {0.0f, 1.0f, 1e17f}) {
        const Mesh point{{{at, at, at}}, {{0, 0, 0}}};
        static_cast<void>(CameraRays(fit_camera(point, kUp, brute_force(point)), 1.0f));
    }
}
