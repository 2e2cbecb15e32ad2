// References: one for each active triangle in the order of ids, with its box and without negative zeros; and the bounds
// of all.
#include "host/build/primitive_bounds.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "support/expect_error.hpp"
#include "support/meshes.hpp"
#include "support/references.hpp"

using namespace clbvh;
using namespace clbvh::test;
using host::Reference;

TEST_CASE("references of all and of some triangles") {
    for (const std::size_t size : {1u, 100u, 8192u, 8193u, 50000u}) {
        for (const std::size_t step : {0u, 1u, 2u, 3u, 5000u}) {
            Mesh mesh = random_triangles(size);
            if (step > 0) deactivate_triangles(mesh, 0, step);
            std::vector<std::uint32_t> active;
            for (std::uint32_t i = 0; i < size; ++i) {
                if (!is_inactive(mesh, i)) active.push_back(i);
            }
            Scratch scratch;
            std::vector<Reference> references(active.size());
            const host::Bounds bounds = host::bound_primitives(mesh, references, scratch);
            const auto same = [](const Box4& box, const Aabb& expected) {
                return make_node(box, 0, 0).bounds() == expected;
            };
            Aabb box, centroids;
            for (const std::uint32_t i : active) {
                box = merge(box, triangle_bounds(mesh, i));
                centroids = merge(centroids, doubled_centroid(triangle_bounds(mesh, i)));
            }
            CHECK(same(bounds.box, box));
            CHECK(same(bounds.centroids, centroids));
            for (std::size_t i = 0; i < active.size(); ++i) {
                REQUIRE(references[i].primitive == active[i]);
                REQUIRE(references[i].bounds() == triangle_bounds(mesh, active[i]));
            }
        }
    }
}

TEST_CASE("references hold no negative zero") {
    Mesh mesh = random_triangles(10);
    for (Vec3& v : mesh.vertices)
        v = {-0.0f, v.y > 0.0f ? -0.0f : v.y, -0.0f};
    for (const Reference& reference : references_of(mesh)) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            CHECK_FALSE((reference.lower[axis] == 0.0f && std::signbit(reference.lower[axis])));
            CHECK_FALSE((reference.upper[axis] == 0.0f && std::signbit(reference.upper[axis])));
        }
    }
}
