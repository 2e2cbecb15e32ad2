// Layouts that the device made, traced where they lie by kernels that are not the library's own.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "clbvh/device/device_tracer.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/trace/tracer.hpp"
#include "device/opencl/session.hpp"
#include "embed/embedded_kernels.hpp"
#include "support/builders.hpp"
#include "support/found_rays.hpp"
#include "support/uploaded_scene.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

// How much is in the leaves is read where the device wrote it: nobody waits for that number.
constexpr const char* kKernels = R"(
#define ARGUMENTS                                                                                   \
    __global const uchar *layout, ulong header, ulong nodes, ulong elements, __global const float *vertices, \
        __global const uint *indices, __global const float4 *rays, __global float4 *hits
#define COUNT (((__global const uint*)(layout + header))[1])
#define ELEMENTS ((__global const float4*)(layout + elements))
#define RAY clbvh_load_ray(rays, get_global_id(0))

__kernel void trace_wide8(ARGUMENTS) {
    const clbvh_wide8 scene = {(__global const float8*)(layout + nodes), ELEMENTS, COUNT};
    clbvh_store_hit(hits, get_global_id(0), clbvh_closest_wide8(scene, RAY, 0));
}

__kernel void trace_wide4(ARGUMENTS) {
    const clbvh_wide4 scene = {(__global const float4*)(layout + nodes), ELEMENTS, COUNT};
    clbvh_store_hit(hits, get_global_id(0), clbvh_closest_wide4(scene, RAY, 0));
}

__kernel void trace_compressed8(ARGUMENTS) {
    const clbvh_compressed8 scene = {(__global const uint4*)(layout + nodes), ELEMENTS, COUNT, vertices, indices};
    clbvh_store_hit(hits, get_global_id(0), clbvh_closest_compressed8(scene, RAY, 0));
}
)";

}  // namespace

TEST_CASE("embedded: layouts that the device made are traced where they lie") {
    const Mesh mesh = generate_scene("city", 3000);
    const Bvh bvh = build(mesh, "hploc");
    const std::vector<Ray> rays = rays_for(mesh, 50);
    std::vector<Hit> expected(rays.size()), found(rays.size());
    Tracer(bvh, mesh).closest(rays, expected);
    const UploadedScene uploaded(bvh, mesh);
    DeviceScene scene = uploaded.scene;
    const cl::Buffer ray_buffer = upload(rays), hits = upload(found);
    cl::Program program = build_embedded(kKernels, device_is_exact() ? "-cl-fp32-correctly-rounded-divide-sqrt" : "");
    cl::CommandQueue queue = shared_context().session().queue();
    DeviceTracer tracer(shared_context());
    for (const LayoutKind kind : {LayoutKind::wide8, LayoutKind::wide4, LayoutKind::compressed8}) {
        INFO(to_string(kind));
        const cl::Buffer layout(shared_context().session().context(), CL_MEM_READ_WRITE,
                                tracer.sizes(scene.bvh, kind).layout);
        scene.layout = {layout()};
        scene.layout_kind = kind;
        tracer.enqueue_layout(queue(), scene);
        const DeviceLayout parts = DeviceTracer::layout_of(scene);
        cl::KernelFunctor<cl::Buffer, cl_ulong, cl_ulong, cl_ulong, cl::Buffer, cl::Buffer, cl::Buffer, cl::Buffer>
            trace(program, "trace_" + std::string(to_string(kind)));
        trace(cl::EnqueueArgs(queue, cl::NDRange(rays.size())), layout, parts.header.offset, parts.nodes.offset,
              parts.elements.offset, uploaded.vertices, uploaded.indices, ray_buffer, hits);
        queue.enqueueReadBuffer(hits, CL_TRUE, 0, found.size() * sizeof(Hit), found.data());
        if (device_is_exact()) CHECK(count_differences(found, expected) == 0);
    }
}
