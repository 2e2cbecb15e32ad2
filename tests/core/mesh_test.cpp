#include "clbvh/core/mesh.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/primitive_limit.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Long enough that the check runs in several pieces.
constexpr std::size_t kLong = 50000;

void expect_invalid(const Mesh& mesh, std::initializer_list<std::string> parts) {
    expect_error(ErrorCode::invalid_input, parts, [&] { (void)check_mesh(mesh); });
}

}  // namespace

TEST_CASE("a mesh without triangles passes the check") {
    CHECK(check_mesh({}) == 0);
    CHECK(check_mesh(Mesh{{{kInfinity, kNan, 0}}, {}}) == 0);
}

TEST_CASE("a sound mesh passes the check") {
    CHECK(check_mesh(random_triangles(1)) == 0);
    CHECK(check_mesh(random_triangles(kLong)) == 0);
}

TEST_CASE("triangles with a NaN are inactive and counted") {
    Mesh mesh = random_triangles(kLong);
    deactivate_triangles(mesh, 5, 7);
    std::uint64_t inactive = 0;
    for (std::size_t i = 0; i < kLong; ++i) {
        const bool expected = i % 7 == 5;
        if (is_inactive(mesh, i) != expected) FAIL("triangle " << i);
        inactive += expected;
    }
    CHECK(check_mesh(mesh) == inactive);
    deactivate_triangles(mesh);
    CHECK(check_mesh(mesh) == kLong);
}

TEST_CASE("one NaN in any coordinate of any vertex makes a triangle inactive") {
    for (const std::size_t corner : {0u, 1u, 2u}) {
        for (float Vec3::*axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
            Mesh mesh = random_triangles(1);
            CHECK_FALSE(is_inactive(mesh, 0));
            mesh.vertices[corner].*axis = -kNan;
            CHECK(is_inactive(mesh, 0));
            CHECK(check_mesh(mesh) == 1);
        }
    }
}

TEST_CASE("an index out of range is an error that names triangle, index and vertex count") {
    Mesh mesh = random_triangles(34);
    mesh.vertices.resize(34);
    mesh.triangles.assign(20, {0, 1, 2});
    mesh.triangles[17] = {3, 99, 5};
    expect_invalid(mesh, {"triangle 17: vertex index 99 is out of range (the mesh has 34 vertices)"});
    mesh.triangles[17] = {3, 5, 34};
    expect_invalid(mesh, {"triangle 17: vertex index 34 is out of range"});
    mesh.triangles[17] = {~0u, 5, 33};
    expect_invalid(mesh, {"triangle 17: vertex index 4294967295 is out of range"});
    mesh.triangles[17] = {3, 5, 33};
    CHECK(check_mesh(mesh) == 0);
}

TEST_CASE("an index out of range is an error even where another vertex is NaN") {
    Mesh mesh = random_triangles(2);
    mesh.vertices[3].x = kNan;
    mesh.triangles[1][2] = 6;
    expect_invalid(mesh, {"triangle 1: vertex index 6"});
}

TEST_CASE("infinite and very large coordinates are errors that name the triangle, the vertex and the value") {
    Mesh mesh = random_triangles(3);
    mesh.vertices[7].z = kInfinity;
    expect_invalid(mesh, {"triangle 2: coordinate z of vertex 7 is inf", "at most 1e+18"});
    mesh.vertices[7].x = -kInfinity;
    expect_invalid(mesh, {"triangle 2: coordinate x of vertex 7 is -inf"});
    mesh.vertices[7] = {0, -1e30f, 0};
    expect_invalid(mesh, {"triangle 2: coordinate y of vertex 7 is -1e+30"});
    mesh.vertices[7] = {0, std::nextafter(kMaxCoordinate, kInfinity), 0};
    expect_invalid(mesh, {"triangle 2"});
    mesh.vertices[7] = {-kMaxCoordinate, kMaxCoordinate, 0};
    CHECK(check_mesh(mesh) == 0);
}

TEST_CASE("other coordinates of an inactive triangle are not checked, nor are unused vertices") {
    Mesh mesh = random_triangles(2);
    mesh.vertices[3] = {kInfinity, 0, 0};
    mesh.vertices[5] = {0, kNan, 0};
    mesh.vertices.push_back({1e30f, 0, 0});
    CHECK(check_mesh(mesh) == 1);
}

TEST_CASE("the offender with the lowest index is named, whichever thread finds one first") {
    Mesh mesh = random_triangles(kLong);
    for (const std::size_t offender : {kLong - 1, kLong / 2, std::size_t{12345}, std::size_t{17}, std::size_t{0}}) {
        mesh.vertices[3 * offender + 1].y = kInfinity;
        for (int repeat = 0; repeat < 10; ++repeat) {
            expect_invalid(mesh, {"triangle " + std::to_string(offender) + ":"});
        }
    }
}

TEST_CASE("more primitives than one build can take are unsupported") {
    CHECK_NOTHROW(check_primitive_count(kMaxPrimitives, "triangles"));
    expect_error(ErrorCode::unsupported, {"1073741824 boxes", "1073741823", "split them up"},
                 [] { check_primitive_count(kMaxPrimitives + 1, "boxes"); });
}
