// A tree refitted on the device in one shape, beside the host's: what Oclgrind watches.
//   oclgrind_refit_tree (group | lane)

#include <array>
#include <clbvh/clbvh.hpp>
#include <clbvh/device/device_refitter.hpp>
#include <clbvh/io/scene.hpp>
#include <clbvh/optimize/refit.hpp>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <span>
#include <string>
#include <vector>

#include "device_buffer.hpp"
#include "run_main.hpp"

namespace {

int run(const std::string& shape) {
    clbvh::Mesh mesh = clbvh::generate_scene("soup", 3000);
    clbvh::Bvh expected = clbvh::build(mesh, "locally-ordered");
    const std::vector<clbvh::Node> nodes_before = expected.nodes;
    for (clbvh::Vec3& vertex : mesh.vertices)
        vertex.x += 0.3f * std::sin(5.0f * vertex.y);
    const clbvh::RefitStats stats = clbvh::refit(expected, mesh);

    const clbvh::Context context = clbvh::Context::open();
    clbvh::DeviceRefitterOptions options;
    options.shape = shape == "group" ? clbvh::Shape::group : clbvh::Shape::lane;
    clbvh::DeviceRefitter refitter(context, options);
    const auto node_count = static_cast<std::uint32_t>(expected.nodes.size());
    const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
    const clbvh::DeviceRefitSizes sizes = refitter.sizes(node_count, count);
    const DeviceBuffer nodes(context, nodes_before), ids(context, expected.primitive_ids),
        vertices(context, mesh.vertices), indices(context, mesh.triangles), order(context, sizes.order),
        scratch(context, sizes.scratch), sah(context, 8);
    clbvh::DeviceTriangles triangles;
    triangles.count = count;
    triangles.vertices = vertices.span();
    triangles.indices = indices.span();
    const clbvh::DeviceBvh tree{nodes.span(), node_count, ids.span(), count, {}};
    refitter.enqueue_order(context.opencl_queue(), tree, order.span());
    refitter.enqueue(context.opencl_queue(), tree, {triangles, order.span(), scratch.span(), sah.span()});
    std::vector<clbvh::Node> fitted(node_count);
    std::array<float, 2> costs{};
    nodes.read<clbvh::Node>(context, fitted);
    sah.read<float>(context, costs);
    refitter.enqueue_cost(context.opencl_queue(), tree, scratch.span(), sah.span());
    std::array<float, 1> cost{};
    sah.read<float>(context, cost);
    const auto is_near = [](double a, double b) { return std::abs(a - b) <= 1e-6 * b; };
    const bool are_same = fitted == expected.nodes && is_near(costs[0], stats.sah_before) &&
                          is_near(costs[1], stats.sah_after) && is_near(cost[0], stats.sah_after);
    if (!are_same) std::cerr << "the device's tree or its cost is not the host's\n";
    return are_same ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace

int main(int argument_count, char** arguments) {
    return run_main([&] { return argument_count == 2 ? run(arguments[1]) : EXIT_FAILURE; });
}
