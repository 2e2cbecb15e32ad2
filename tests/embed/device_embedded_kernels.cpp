#include <array>
#include <bit>
#include <catch2/catch.hpp>

#include "clbvh/device/device_tracer.hpp"
#include "clbvh/embed.hpp"
#include "device/opencl/session.hpp"
#include "embed/embedded_kernels.hpp"
#include "support/builders.hpp"

namespace clbvh::test {
namespace {

constexpr const char* kKernels = R"(
#ifdef CLBVH_ACCEPT_HIT
int CLBVH_ACCEPT_HIT(clbvh_ray ray, clbvh_hit hit, uint solid) {
    return hit.primitive % solid != 0 && hit.t <= ray.t_max;
}
#endif

#ifndef CAPACITY
#define CAPACITY 4
#endif

clbvh_wide8 wide8_scene(__global const float4* nodes, __global const float4* leaves, uint count,
                        __global const float* vertices, __global const uint* indices) {
    clbvh_wide8 scene = {(__global const float8*)nodes, leaves, count};
    return scene;
}

clbvh_binary binary_scene(__global const float4* nodes, __global const float4* leaves, uint count,
                          __global const float* vertices, __global const uint* indices) {
    clbvh_binary scene = {nodes, (__global const uint*)leaves, count, vertices, indices};
    return scene;
}

clbvh_pair pair_scene(__global const float4* nodes, __global const float4* leaves, uint count,
                      __global const float* vertices, __global const uint* indices) {
    clbvh_pair scene = {nodes, (__global const uint*)leaves, count, vertices, indices};
    return scene;
}

clbvh_skip skip_scene(__global const float4* nodes, __global const float4* leaves, uint count,
                      __global const float* vertices, __global const uint* indices) {
    clbvh_skip scene = {nodes, (__global const uint*)leaves, count, vertices, indices};
    return scene;
}

#define SCENE_ARGUMENTS                                                                                        \
    __global const float4 *nodes, __global const float4 *leaves, uint count, __global const float *vertices, \
        __global const uint *indices, __global const float4 *rays, uint solid
#define SCENE SCENE_OF(nodes, leaves, count, vertices, indices)

__kernel void find_closest(SCENE_ARGUMENTS, __global float4* hits) {
    const size_t i = get_global_id(0);
    clbvh_store_hit(hits, i, clbvh_closest(SCENE, clbvh_load_ray(rays, i), solid));
}

__kernel void find_any(SCENE_ARGUMENTS, __global uchar* hits) {
    const size_t i = get_global_id(0);
    hits[i] = clbvh_any(SCENE, clbvh_load_ray(rays, i), solid) ? 1 : 0;
}

uint digest(uint before, uint value) { return (before ^ value) * 16777619u; }

__kernel void find_all(SCENE_ARGUMENTS, __global uint2* results) {
    const size_t i = get_global_id(0);
    const clbvh_scene scene = SCENE;
    const clbvh_ray ray = clbvh_load_ray(rays, i);
    clbvh_hit hits[CAPACITY];
    clbvh_hit last = CLBVH_FIRST;
    uint2 result = (uint2)(0, 0x811C9DC5u);
    for (;;) {
        const uint found = clbvh_all(scene, ray, last, hits, CAPACITY, solid);
        for (uint k = 0; k < found; ++k) {
            last = hits[k];
            ++result.x;
            result.y = digest(digest(result.y, as_uint(last.t)), as_uint(last.u));
            result.y = digest(digest(result.y, as_uint(last.v)), last.primitive);
        }
        if (found < CAPACITY) break;
    }
    results[i] = result;
}
)";

const cl::Context& context() {
    return shared_context().session().context();
}

/// `values` in device memory, of which there is some also where there are none.
template <typename T>
cl::Buffer buffer_of(const T* values, std::size_t count) {
    const std::size_t bytes = std::max<std::size_t>(count * sizeof(T), 256);
    cl::Buffer buffer(context(), CL_MEM_READ_WRITE, bytes);
    if (count > 0) shared_context().session().queue().enqueueWriteBuffer(buffer, CL_TRUE, 0, count * sizeof(T), values);
    return buffer;
}

}  // namespace

void AllHits::add(const Hit& hit) noexcept {
    ++count;
    for (const std::uint32_t value : {std::bit_cast<std::uint32_t>(hit.t), std::bit_cast<std::uint32_t>(hit.u),
                                      std::bit_cast<std::uint32_t>(hit.v), hit.primitive})
        digest = (digest ^ value) * 16777619U;
}

cl::Program build_embedded(const std::string& source, const std::string& options) {
    cl::Program program(context(), std::string(embed_source()) + source);
    try {
        program.build(options.c_str());
    } catch (const cl::BuildError& error) {
        FAIL(options << ": " << error.getBuildLog().front().second);
    }
    return program;
}

bool device_is_exact() {
    static const bool is_exact = DeviceTracer(shared_context()).is_exact();
    return is_exact;
}

EmbeddedScene::EmbeddedScene(const Wide8& layout)
    : layout_("wide8"),
      count_(static_cast<std::uint32_t>(layout.blocks.size())),
      nodes_(buffer_of(layout.nodes.data(), layout.nodes.size())),
      leaves_(buffer_of(layout.blocks.data(), layout.blocks.size())) {}

template <typename Tree>
EmbeddedScene::EmbeddedScene(const char* layout, const Tree& tree, std::size_t count, const Mesh& mesh)
    : layout_(layout),
      count_(static_cast<std::uint32_t>(count)),
      nodes_(buffer_of(tree.nodes.data(), tree.nodes.size())),
      leaves_(buffer_of(tree.primitive_ids.data(), tree.primitive_ids.size())),
      vertices_(buffer_of(mesh.vertices.data(), mesh.vertices.size())),
      indices_(buffer_of(mesh.triangles.data(), mesh.triangles.size())) {}

EmbeddedScene::EmbeddedScene(const Bvh& bvh, const Mesh& mesh)
    : EmbeddedScene("binary", bvh, bvh.primitive_ids.size(), mesh) {}
EmbeddedScene::EmbeddedScene(const PairLayout& layout, const Mesh& mesh)
    : EmbeddedScene("pair", layout, layout.primitive_ids.size(), mesh) {}
EmbeddedScene::EmbeddedScene(const SkipLayout& layout, const Mesh& mesh)
    : EmbeddedScene("skip", layout, layout.nodes.size(), mesh) {}

Embedded EmbeddedScene::trace(const std::string& options, std::span<const Ray> rays, std::uint32_t solid) const {
    const std::string layout = " -DCLBVH_LAYOUT=" + layout_ + " -DSCENE_OF=" + layout_ + "_scene -DCLBVH_USER=uint ";
    const std::string rounding = device_is_exact() ? " -cl-fp32-correctly-rounded-divide-sqrt " : "";
    const cl::Program program = build_embedded(kKernels, options + layout + rounding);
    const cl::CommandQueue& queue = shared_context().session().queue();
    const cl::Buffer ray_buffer = buffer_of(rays.data(), rays.size());
    const auto run = [&](const char* name, auto& results) {
        const cl::Buffer buffer = buffer_of(results.data(), results.size());
        cl::Kernel kernel(program, name);
        cl_uint argument = 0;
        const auto set = [&](const auto& value) { kernel.setArg(argument++, value); };
        set(nodes_);
        set(leaves_);
        set(count_);
        set(vertices_);
        set(indices_);
        set(ray_buffer);
        set(solid);
        set(buffer);
        queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(rays.size()));
        queue.enqueueReadBuffer(buffer, CL_TRUE, 0, results.size() * sizeof(results[0]), results.data());
    };
    Embedded found{std::vector<Hit>(rays.size()), std::vector<std::uint8_t>(rays.size()),
                   std::vector<AllHits>(rays.size())};
    run("find_closest", found.closest);
    run("find_any", found.any);
    run("find_all", found.all);
    return found;
}

}  // namespace clbvh::test
