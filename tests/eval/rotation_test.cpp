#include "clbvh/eval/rotation.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "support/expect_error.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

void check_near(const Vec3& a, const Vec3& b, float tolerance) {
    CHECK(std::abs(a.x - b.x) <= tolerance);
    CHECK(std::abs(a.y - b.y) <= tolerance);
    CHECK(std::abs(a.z - b.z) <= tolerance);
}

double distance(const Vec3& a, const Vec3& b) {
    return std::hypot(double{a.x} - b.x, double{a.y} - b.y, double{a.z} - b.z);
}

}  // namespace

TEST_CASE("a rotation turns counterclockwise about its axis") {
    check_near(Rotation({0, 0, 5}, 90)({1, 2, 3}), {-2, 1, 3}, 1e-6f);
    check_near(Rotation({1, 0, 0}, 90)({1, 2, 3}), {1, -3, 2}, 1e-6f);
    check_near(Rotation({0, -1, 0}, -90)({1, 2, 3}), {3, 2, -1}, 1e-6f);
    check_near(Rotation({1, 1, 1}, 120)({1, 2, 3}), {3, 1, 2}, 1e-6f);
    check_near(Rotation({1, 1, 1}, -240)({1, 2, 3}), {3, 1, 2}, 1e-6f);
    check_near(Rotation({1, 1, 1}, 60)({2, 2, 2}), {2, 2, 2}, 1e-6f);
}

TEST_CASE("whole turns change nothing, however many") {
    for (const double degrees : {0.0, 360.0, -720.0, 360e9})
        CHECK(Rotation({1, 2, -3}, degrees)({0.1f, -5.0f, 1e18f}) == Vec3{0.1f, -5.0f, 1e18f});
}

TEST_CASE("a turned mesh keeps its triangles and all distances, and turns back") {
    const Mesh mesh = random_triangles(500);
    for (const double degrees : {1.0, 45.0, 90.0, 200.0, -33.3}) {
        const Mesh turned = rotated(mesh, Rotation({1, 1, 1}, degrees));
        CHECK(turned.triangles == mesh.triangles);
        REQUIRE(turned.vertices.size() == mesh.vertices.size());
        const Mesh back = rotated(turned, Rotation({1, 1, 1}, -degrees));
        for (std::size_t i = 1; i < mesh.vertices.size(); ++i) {
            const double before = distance(mesh.vertices[i - 1], mesh.vertices[i]);
            REQUIRE(distance(turned.vertices[i - 1], turned.vertices[i]) == Approx(before).margin(1e-4));
            REQUIRE(distance(back.vertices[i], mesh.vertices[i]) < 1e-4);
        }
    }
}

TEST_CASE("vertices that are not finite stay as they are, so that triangles stay inactive and meshes refused") {
    const Rotation rotation({1, 1, 1}, 45);
    const Vec3 turned = rotation({1, kNan, 3});
    CHECK(turned.x == 1.0f);
    CHECK(std::isnan(turned.y));
    CHECK(rotation({1, kInfinity, 3}) == Vec3{1, kInfinity, 3});
    Mesh mesh = random_triangles(10);
    deactivate_triangles(mesh, 1, 2);
    CHECK(check_mesh(rotated(mesh, rotation)) == 5);
    mesh.vertices[0].x = kInfinity;
    expect_error(ErrorCode::invalid_input, {"triangle 0"}, [&] { (void)check_mesh(rotated(mesh, rotation)); });
}

TEST_CASE("a rotation without an axis or an angle is refused") {
    for (const Vec3& axis : {Vec3{}, Vec3{kNan, 0, 1}, Vec3{0, kInfinity, 0}})
        expect_error(ErrorCode::invalid_input, {"axis"}, [&] { Rotation(axis, 1); });
    for (const double degrees : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
        expect_error(ErrorCode::invalid_input, {"angle"}, [&] { Rotation({1, 1, 1}, degrees); });
}
