// Rays on the device in one shape, beside the host's: what Oclgrind watches.
//   oclgrind_trace_rays (group | lane) STACK_ENTRIES PERSISTENT_GROUPS

#include <clbvh/clbvh.hpp>
#include <clbvh/io/scene.hpp>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <span>
#include <string>
#include <vector>

#include "run_main.hpp"

namespace {

/// From vertices scaled up by a third to other vertices.
std::vector<clbvh::Ray> rays_through(const clbvh::Mesh& mesh) {
    std::vector<clbvh::Ray> rays;
    for (std::size_t i = 0; i < 150; ++i) {
        const clbvh::Vec3& from = mesh.vertices[i * 7 % mesh.vertices.size()];
        const clbvh::Vec3& to = mesh.vertices[i * 31 % mesh.vertices.size()];
        clbvh::Ray ray;
        ray.origin = {1.3f * from.x, 1.3f * from.y, from.z};
        ray.direction = {to.x - ray.origin.x, to.y - ray.origin.y, to.z - ray.origin.z};
        rays.push_back(ray);
    }
    return rays;
}

int run(std::span<char*> arguments) {
    clbvh::DeviceTracerOptions options;
    const bool is_group = std::string(arguments[1]) == "group";
    options.shape = is_group ? clbvh::Shape::group : clbvh::Shape::lane;
    if (is_group) options.work_group_size = 16;
    options.stack_entries = static_cast<std::uint32_t>(std::stoul(arguments[2]));

    const clbvh::Mesh mesh = clbvh::generate_scene("soup", 600);
    const clbvh::Bvh bvh = clbvh::build(mesh, "locally-ordered");
    const std::vector<clbvh::Ray> rays = rays_through(mesh);
    std::vector<clbvh::Hit> hits(rays.size()), expected(rays.size()), uncounted(rays.size());
    std::vector<clbvh::RayCounts> counts(rays.size()), expected_counts(rays.size());
    std::vector<std::uint8_t> is_hit(rays.size()), expected_is_hit(rays.size());
    const clbvh::BinaryTracer host(bvh, mesh);
    std::vector<clbvh::RayCounts> any_counts(rays.size());
    host.closest(rays, expected, expected_counts);
    host.any(rays, expected_is_hit, any_counts);
    clbvh::DeviceTracer device(clbvh::Context::open(), options);
    device.set_scene(bvh, mesh);
    device.closest(rays, hits, counts);
    device.closest(rays, uncounted);
    device.any(rays, is_hit);
    const bool are_same =
        hits == expected && uncounted == expected && counts == expected_counts && is_hit == expected_is_hit;
    if (!are_same) std::cerr << "the device's hits are not the host's\n";
    return are_same ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace

int main(int argument_count, char** arguments) {
    return run_main([&] { return run({arguments, static_cast<std::size_t>(argument_count)}); });
}
