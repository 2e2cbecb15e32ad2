// Far things, and large ones, cost a ray next to nothing, with every builder and preset.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "clbvh/catalog.hpp"
#include "clbvh/core/vector.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/trace/binary_tracer.hpp"
#include "core/random.hpp"
#include "support/builders.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr std::uint64_t kTriangles = 6000;

/// Rays within the unit cube, from a place in it into any direction.
std::vector<Ray> rays_in_cube() {
    Random random(3);
    std::vector<Ray> rays;
    while (rays.size() < 2000) {
        const Vec3 origin = random.in_cube(0, 1);
        const Vec3 direction = random.in_cube(-1, 1);
        if (dot(direction, direction) > 0.01f) rays.push_back({origin, 0, direction, 0.5f});
    }
    return rays;
}

/// Inner nodes that these rays visit in the builder's tree.
double visits(Builder& builder, const Mesh& mesh) {
    const Bvh bvh = builder.build(mesh);
    const BinaryTracer tracer(bvh, mesh);
    double sum = 0;
    for (const Ray& ray : rays_in_cube()) {
        RayCounts counts;
        static_cast<void>(tracer.closest(ray, counts));
        sum += static_cast<double>(counts.inner_nodes);
    }
    return sum;
}

/// The same triangles in the unit cube, with nothing else.
Mesh without_far_things(const Mesh& mesh) {
    Mesh rest = mesh;
    std::erase_if(rest.triangles, [&](const Triangle& triangle) {
        const Vec3& a = mesh.vertices[triangle[0]];
        const Vec3& b = mesh.vertices[triangle[1]];
        return std::abs(a.x) > 2 || std::abs(a.y) > 2 || std::abs(a.z) > 2 || std::abs(b.x) > 2 || std::abs(b.y) > 2 ||
               std::abs(b.z) > 2;
    });
    return rest;
}

}  // namespace

TEST_CASE("far and large things hardly cost a ray that does not meet them, whatever the builder", "[far_scenes]") {
    std::vector<std::string> ids;
    for (const BuilderInfo& builder : builders())
        if (can_run(builder.id)) ids.emplace_back(builder.id);
    for (const PresetInfo& preset : presets())
        if (can_run(preset.id)) ids.emplace_back(preset.id);
    Builder binned = make_builder("binned-sah");
    for (const std::string scene : {"outlier:1e2", "outlier:1e3", "outlier:1e4", "outlier:1e6", "outlier:1e12",
                                    "two-objects:1e6", "planes", "sky"}) {
        const Mesh mesh = generate_scene(scene, kTriangles);
        const Mesh rest = without_far_things(mesh);
        // Boxes of a sky's parts are around everything: some nodes more there have to be.
        const double unavoidable = std::max(1.0, visits(binned, mesh) / visits(binned, rest));
        for (const std::string& id : ids) {
            Builder builder = make_builder(id);
            INFO(id << " over gen:" << scene);
            CHECK(visits(builder, mesh) / visits(builder, rest) < 1.25 * unavoidable);
        }
    }
}
