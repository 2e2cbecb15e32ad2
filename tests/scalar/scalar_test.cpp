// The rooms host and trace compiled without any vectors, as for a processor that has none, build the same trees and
// find the same hits, to the bit.
#include <catch2/catch.hpp>

#include "clbvh/io/scene.hpp"
#include "scalar/hit_bytes.hpp"
#include "scalar/tree_bytes.hpp"
#include "support/builders.hpp"
#include "support/oracle/ray_oracle.hpp"

namespace clbvh_scalar::test {
[[nodiscard]] std::vector<std::uint8_t> tree_bytes(std::string_view id, const std::vector<float>& triangles);
[[nodiscard]] std::vector<std::uint8_t> hit_bytes(const std::vector<float>& triangles, const std::vector<float>& rays);
}  // namespace clbvh_scalar::test

using namespace clbvh;
using namespace clbvh::test;

namespace {

std::vector<float> floats_of(const Mesh& mesh) {
    std::vector<float> floats;
    for (const Triangle& triangle : mesh.triangles) {
        for (const std::uint32_t corner : triangle) {
            const Vec3& v = mesh.vertices[corner];
            floats.insert(floats.end(), {v.x, v.y, v.z});
        }
    }
    return floats;
}

std::vector<float> floats_of(const std::vector<Ray>& rays) {
    std::vector<float> floats;
    for (const Ray& ray : rays) {
        const Vec3 &o = ray.origin, &d = ray.direction;
        floats.insert(floats.end(), {o.x, o.y, o.z, ray.t_min, d.x, d.y, d.z, ray.t_max});
    }
    return floats;
}

}  // namespace

TEST_CASE("host builders give the same bytes without vectors") {
    for (const SceneGeneratorInfo& scene : scene_generators()) {
        for (const std::uint32_t size : {1u, 7u, 3000u}) {
            const Mesh mesh = generate_scene(scene.name, size);
            const std::vector<float> triangles = floats_of(mesh);
            for (const std::string_view id : host_builders()) {
                INFO(id << " on " << scene.name << ":" << size);
                const bool same = tree_bytes(id, triangles) == clbvh_scalar::test::tree_bytes(id, triangles);
                CHECK(same);
            }
        }
    }
}

TEST_CASE("the host tracer finds the same bits without vectors") {
    for (const SceneGeneratorInfo& scene : scene_generators()) {
        INFO(scene.name);
        const Mesh mesh = generate_scene(scene.name, 2000);
        const std::vector<float> triangles = floats_of(mesh), rays = floats_of(difficult_rays(mesh, 200));
        const bool same = hit_bytes(triangles, rays) == clbvh_scalar::test::hit_bytes(triangles, rays);
        CHECK(same);
    }
}
