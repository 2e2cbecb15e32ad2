// Views of the caller's arrays on a device: rays find the same whatever the layout, and on CPU devices nothing is
// copied.
#include <catch2/catch.hpp>
#include <string_view>
#include <vector>

#include "clbvh/clbvh.hpp"
#include "clbvh/io/scene.hpp"
#include "support/allocations.hpp"
#include "support/box_sets.hpp"
#include "support/builders.hpp"
#include "support/opencl_calls.hpp"
#include "support/views.hpp"

using namespace clbvh;
using namespace clbvh::test;

TEST_CASE("views: rays on a device in every layout", "[views]") {
    const Mesh mesh = mesh_with_inactive();
    const Bvh tree = make_builder("sbvh").build(mesh);
    const Tracer tracer(tree, mesh);
    const std::vector<Ray> rays = rays_to_vertices(tree.nodes[0].bounds(), mesh);
    DeviceTracer device_tracer(shared_context());
    for (const ViewedMesh& layout : layouts_of(mesh)) {
        INFO(layout.name);
        device_tracer.set_scene(tree, layout.view);
        std::vector<Hit> hits(rays.size());
        device_tracer.closest(rays, hits);
        for (std::size_t i = 0; i < rays.size(); ++i)
            CHECK(hits[i] == tracer.closest(rays[i]));
    }
}

TEST_CASE("views: builds on CPU devices copy nothing of the caller's", "[views]") {
    if (shared_context().device().type != DeviceType::cpu) return;
    const Mesh mesh = generate_scene("city", 20000);
    const std::vector<Aabb> set = random_boxes(20000);
    for (const std::string_view id : device_builders()) {
        INFO(id);
        Builder builder = make_builder(id);
        const OpenClCalls calls = opencl_calls_of([&] { builder.upload(mesh); });
        CHECK(calls.buffers == 2);
        CHECK(calls.copied == 0);
        builder.run();
        CHECK(opencl_calls_of([&] { builder.run(); }).copied == 0);
        CHECK(opencl_calls_of([&] { builder.upload(set); }).copied == 0);
        CHECK(allocations_of(60000, [&] { builder.upload(mesh); }) == 0);
    }
}
