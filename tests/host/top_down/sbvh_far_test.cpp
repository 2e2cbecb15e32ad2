// Far from the origin the boxes of cut parts are grown by a good part of their size, and cutting a part once more takes
// some of that away again: trees are proven all the same, whichever stage cut the triangles first.
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <utility>

#include "clbvh/builder.hpp"
#include "clbvh/core/validate.hpp"
#include "clbvh/io/scene.hpp"

using namespace clbvh;

namespace {

struct Way {
    const char* name;
    std::uint32_t presplit_level;
    float split_quota;
};
constexpr std::array kWays{Way{"not split before", 0, 0.0f}, Way{"presplit_level 14", 14, 0.0f},
                           Way{"split_quota 0.3", 0, 0.3f}, Way{"split_quota 4", 0, 4.0f}};

/// Moves the mesh along the axes whose bits are set.
Mesh moved(Mesh mesh, unsigned axes, float offset) {
    for (Vec3& vertex : mesh.vertices) {
        vertex.x += (axes & 1) != 0 ? offset : 0.0f;
        vertex.y += (axes & 2) != 0 ? offset : 0.0f;
        vertex.z += (axes & 4) != 0 ? offset : 0.0f;
    }
    return mesh;
}

}  // namespace

TEST_CASE("sbvh is valid far from the origin, whether or not triangles are split before") {
    for (const auto& [scene, count] : {std::pair{"hair", 200u}, {"hair", 400u}, {"city", 400u}}) {
        const Mesh mesh = generate_scene(scene, count);
        for (const float offset : {1e4f, 1e5f, 3e5f, 1e6f, -3e6f, 1e7f}) {
            for (unsigned axes = 1; axes < 8; ++axes) {
                const Mesh far = moved(mesh, axes, offset);
                for (const Way& way : kWays) {
                    INFO(scene << " " << count << ", " << offset << " along axes " << axes << ", " << way.name);
                    BuildOptions options;
                    options.presplit_level = way.presplit_level;
                    options.split_quota = way.split_quota;
                    const ValidationReport report = validate(Builder("sbvh", options).build(far), far);
                    CHECK(report.error == "");
                }
            }
        }
    }
}
