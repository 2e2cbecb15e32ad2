// The host room compiled without any vectors, as for a processor that has none, builds the same trees to the bit.
#include <catch2/catch.hpp>

#include "clbvh/io/scene.hpp"
#include "scalar/tree_bytes.hpp"
#include "support/builders.hpp"

namespace clbvh_scalar::test {
[[nodiscard]] std::vector<std::uint8_t> tree_bytes(std::string_view id, const std::vector<float>& triangles);
}  // namespace clbvh_scalar::test

using namespace clbvh;
using namespace clbvh::test;

TEST_CASE("host builders give the same bytes without vectors") {
    for (const SceneGeneratorInfo& scene : scene_generators()) {
        for (const std::uint32_t size : {1u, 7u, 3000u}) {
            const Mesh mesh = generate_scene(scene.name, size);
            std::vector<float> triangles;
            for (const Triangle& triangle : mesh.triangles) {
                for (const std::uint32_t corner : triangle) {
                    const Vec3& v = mesh.vertices[corner];
                    triangles.insert(triangles.end(), {v.x, v.y, v.z});
                }
            }
            for (const std::string_view id : host_builders()) {
                INFO(id << " on " << scene.name << ":" << size);
                const bool same = tree_bytes(id, triangles) == clbvh_scalar::test::tree_bytes(id, triangles);
                CHECK(same);
            }
        }
    }
}
