#include "metrics/triangle_surface.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.hpp"
#include "support/oracle/epo_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

Mesh single(const Vec3& a, const Vec3& b, const Vec3& c) {
    return {{a, b, c}, {{0, 1, 2}}};
}

double area_within(const Mesh& mesh, const Aabb& box) {
    return TriangleSurface(mesh, 0).area_within(box);
}

}  // namespace

TEST_CASE("a triangle's area, and its parts in boxes made by hand") {
    const Mesh mesh = single({0, 0, 0}, {4, 0, 0}, {0, 4, 0});
    CHECK(TriangleSurface(mesh, 0).area() == 8.0);
    CHECK(area_within(mesh, {{0, 0, 0}, {4, 4, 0}}) == 8.0);
    CHECK(area_within(mesh, {{-1, -1, -1}, {9, 9, 9}}) == 8.0);
    CHECK(area_within(mesh, {{0, 0, 0}, {1, 1, 1}}) == 1.0);
    CHECK(area_within(mesh, {{1, 1, -1}, {3, 3, 1}}) == 2.0);
    CHECK(area_within(mesh, {{0, 0, -1}, {2, 9, 1}}) == 6.0);
    CHECK(area_within(mesh, {{0, 0, 0.5}, {4, 4, 1}}) == 0.0);
    CHECK(area_within(mesh, {{3, 3, -1}, {4, 4, 1}}) == 0.0);
    CHECK(area_within(mesh, {{4, 0, 0}, {9, 9, 9}}) == 0.0);
    // Only the box of the triangle meets this one; then the plane z = 0 is a face, which is within.
    CHECK(area_within(mesh, {{2.5, 2.5, -1}, {4, 4, 1}}) == 0.0);
    CHECK(area_within(mesh, {{0, 0, -5}, {2, 2, 0}}) == 4.0);
    CHECK(TriangleSurface(single({1, 2, 3}, {1, 2, 3}, {5, 6, 7}), 0).area() == 0.0);
}

TEST_CASE("a triangle's parts in random boxes are as large as they are in the triangle's own plane") {
    Random random(5);
    int parts = 0;
    for (int i = 0; i < 20000; ++i) {
        Mesh mesh = single(random.in_cube(-1, 1), random.in_cube(-1, 1), random.in_cube(-1, 1));
        // Now and then in a plane across an axis, or a sliver.
        if (i % 5 == 0) mesh.vertices[0].y = mesh.vertices[1].y = mesh.vertices[2].y = 0.25f;
        if (i % 7 == 0) mesh.vertices[1] = {mesh.vertices[0].x + 1e-3f, mesh.vertices[0].y, mesh.vertices[0].z};
        const Vec3 corner = random.in_cube(-1, 1);
        Aabb box = merge(Aabb{corner, corner}, random.in_cube(-1, 1));
        if (i % 25 == 0) box.lower.y = 0.25f;
        const double expected = area_within_oracle(mesh, 0, box);
        REQUIRE(area_within(mesh, box) == Approx(expected).margin(1e-9).epsilon(1e-9));
        if (expected > 0.0 && expected < TriangleSurface(mesh, 0).area()) ++parts;
    }
    CHECK(parts > 4000);
}

TEST_CASE("parts of triangles that boxes cut apart add up to the whole, at the largest and the least coordinates") {
    Random random(9);
    for (const float scale : {1.0f, 1e18f, 1e-30f, 0x1p-140f}) {
        for (int i = 0; i < 200; ++i) {
            const auto corner = [&] {
                const Vec3 p = random.in_cube(-1, 1);
                return Vec3{p.x * scale, p.y * scale, p.z * scale};
            };
            const Mesh mesh = single(corner(), corner(), corner());
            const Vec3 middle = corner();
            double sum = 0.0;
            for (unsigned octant = 0; octant < 8; ++octant) {
                Aabb box{{-scale, -scale, -scale}, {scale, scale, scale}};
                ((octant & 1U) != 0 ? box.lower.x : box.upper.x) = middle.x;
                ((octant & 2U) != 0 ? box.lower.y : box.upper.y) = middle.y;
                ((octant & 4U) != 0 ? box.lower.z : box.upper.z) = middle.z;
                sum += area_within(mesh, box);
            }
            REQUIRE(sum == Approx(TriangleSurface(mesh, 0).area()).epsilon(1e-9));
        }
    }
}

TEST_CASE("points of a triangle are where their coordinates say") {
    const TriangleSurface surface(single({1, 2, 3}, {5, 2, 3}, {1, 2, 11}), 0);
    CHECK(surface.at(0, 0) == Point{1, 2, 3});
    CHECK(surface.at(1, 0) == Point{5, 2, 3});
    CHECK(surface.at(0.25, 0.5) == Point{2, 2, 7});
}
