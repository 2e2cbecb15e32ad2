#include "clbvh/eval/mesh_info.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "clbvh/core/mesh.hpp"
#include "clbvh/io/scene.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

TEST_CASE("mesh_info counts triangles of each kind") {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    Mesh mesh;
    mesh.vertices = {{0, 0, 0},     {2, 0, 0},     {0, 2, 0}, {1, 0, 0}, {nan, 0, 0}, {kPositiveInfinity, 0, 0},
                     {-0.0f, 0, 0}, {2e18f, 0, 0}, {0, 0, 7}};
    mesh.triangles = {{0, 1, 2}, {1, 2, 6}, {2, 1, 0}, {0, 1, 3}, {0, 0, 0},
                      {0, 1, 4}, {0, 1, 5}, {4, 5, 0}, {0, 2, 7}};
    const MeshInfo info = mesh_info(mesh);
    CHECK(info.vertices == 9);
    CHECK(info.triangles == 9);
    CHECK(info.out_of_range == 3);
    CHECK(info.inactive == 1);
    CHECK(info.zero_area == 2);
    CHECK(info.duplicates == 2);
    CHECK(info.area == 6.0);
    CHECK(info.bounds == Aabb{{0, 0, 0}, {2, 2, 0}});
}

TEST_CASE("mesh_info of nothing is nothing, and of a sphere what a sphere is") {
    CHECK(mesh_info(Mesh{}).bounds == Aabb{});
    const MeshInfo info = mesh_info(load_scene("gen:sphere:20000"));
    CHECK(info.triangles == 20000);
    CHECK(info.duplicates + info.zero_area + info.inactive + info.out_of_range == 0);
    const double radius = 0.5 * (static_cast<double>(info.bounds.upper.x) - info.bounds.lower.x);
    CHECK(info.area == Approx(4 * 3.14159265358979 * radius * radius).epsilon(2e-3));
}

TEST_CASE("mesh_info finds the area of triangles of any size") {
    for (const float size : {1e-30f, 1e-20f, 1.0f, 1e17f}) {
        Mesh mesh;
        mesh.vertices = {{0, 0, 0}, {size, 0, 0}, {0, size, 0}};
        mesh.triangles = {{0, 1, 2}};
        CHECK(mesh_info(mesh).area == Approx(0.5 * double{size} * size));
        CHECK(mesh_info(mesh).zero_area == 0);
    }
}

TEST_CASE("mesh_info names the first triangle with an index out of range") {
    Mesh mesh;
    mesh.vertices = {{0, 0, 0}};
    mesh.triangles = {{0, 0, 0}, {0, 3, 0}};
    expect_error(ErrorCode::invalid_input, {"triangle 1", "vertex 3"}, [&] { (void)mesh_info(mesh); });
}
