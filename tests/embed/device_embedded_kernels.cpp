#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <map>

#include "clbvh/device/device_tracer.hpp"
#include "clbvh/embed.hpp"
#include "device/opencl/session.hpp"
#include "embed/embedded_kernels.hpp"
#include "support/builders.hpp"

namespace clbvh::test {
namespace {

// As callers would write them. A pattern of holes, none where user[0].x is 0, lets light through triangles;
// primitives of one's own are spheres, user[primitive + 1], which a ray meets where it enters them and, under an odd
// number, where it leaves them.
constexpr const char* kKernels = R"(
#ifdef CLBVH_ACCEPT_HIT
int CLBVH_ACCEPT_HIT(clbvh_ray ray, clbvh_hit hit, __global const float4* user) {
    const uint place = (uint)(hit.u * 8.0f) + (uint)(hit.v * 8.0f) + hit.primitive;
    const uint period = (uint)user[0].x;
    return (period == 0 || place % period != 0) && hit.t <= ray.t_max;
}
#endif

#ifdef CLBVH_INTERSECT_PRIMITIVE
float dot_of(float3 a, float3 b) {
#pragma OPENCL FP_CONTRACT OFF
    return (a.x * b.x + a.y * b.y) + a.z * b.z;
}

int CLBVH_INTERSECT_PRIMITIVE(clbvh_ray ray, uint primitive, __private clbvh_hit* hit, __global const float4* user) {
#pragma OPENCL FP_CONTRACT OFF
    const float4 sphere = user[primitive + 1];
    const float3 from = ray.origin - sphere.xyz;
    const float a = dot_of(ray.direction, ray.direction), b = dot_of(from, ray.direction);
    const float squared = b * b - a * (dot_of(from, from) - sphere.w * sphere.w);
    if (!(squared >= 0.0f)) return 0;
    const float root = sqrt(squared);
    const float enters = (-b - root) / a, leaves = (-b + root) / a;
    const int is_entry = ray.t_min <= enters;
    hit->t = is_entry ? enters : leaves;
    hit->primitive = 2 * primitive + (is_entry ? 0 : 1);
    return ray.t_min <= hit->t && hit->t <= ray.t_max;
}
#endif

#ifndef CAPACITY
#define CAPACITY 4
#endif

#define TREE_ARGUMENTS                                                                                       \
    __global const float4 *nodes, __global const float4 *leaves, uint count, __global const float *vertices, \
        __global const uint *indices

clbvh_wide8 wide8_scene(TREE_ARGUMENTS) {
    clbvh_wide8 scene = {(__global const float8*)nodes, leaves, count};
    return scene;
}

clbvh_wide4 wide4_scene(TREE_ARGUMENTS) {
    clbvh_wide4 scene = {nodes, leaves, count};
    return scene;
}

clbvh_compressed8 compressed8_scene(TREE_ARGUMENTS) {
    clbvh_compressed8 scene = {(__global const uint4*)nodes, leaves, count, vertices, indices};
    return scene;
}

clbvh_binary binary_scene(TREE_ARGUMENTS) {
    clbvh_binary scene = {nodes, (__global const uint*)leaves, count, vertices, indices};
    return scene;
}

clbvh_pair pair_scene(TREE_ARGUMENTS) {
    clbvh_pair scene = {nodes, (__global const uint*)leaves, count, vertices, indices};
    return scene;
}

clbvh_skip skip_scene(TREE_ARGUMENTS) {
    clbvh_skip scene = {nodes, (__global const uint*)leaves, count, vertices, indices};
    return scene;
}

#define SCENE_ARGUMENTS TREE_ARGUMENTS, __global const float4 *rays, __global const float4 *user
#define SCENE SCENE_OF(nodes, leaves, count, vertices, indices)

__kernel void find_closest(SCENE_ARGUMENTS, __global float4* hits) {
    const size_t i = get_global_id(0);
    clbvh_store_hit(hits, i, clbvh_closest(SCENE, clbvh_load_ray(rays, i), user));
}

__kernel void find_any(SCENE_ARGUMENTS, __global uchar* hits) {
    const size_t i = get_global_id(0);
    hits[i] = clbvh_any(SCENE, clbvh_load_ray(rays, i), user) ? 1 : 0;
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
        const uint found = clbvh_all(scene, ray, last, hits, CAPACITY, user);
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

/// What no option of a compiler can say, for its spaces.
const std::string kUser = "#define CLBVH_USER __global const float4*\n";

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
    cl::Program program(context(), kUser + std::string(embed_source()) + source);
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

template <typename Nodes, typename Leaves>
EmbeddedScene::EmbeddedScene(const char* layout, const Nodes& nodes, const Leaves& leaves, std::size_t count)
    : layout_(layout),
      count_(static_cast<std::uint32_t>(count)),
      nodes_(buffer_of(nodes.data(), nodes.size())),
      leaves_(buffer_of(leaves.data(), leaves.size())) {}

void EmbeddedScene::set_mesh(const Mesh& mesh) {
    vertices_ = buffer_of(mesh.vertices.data(), mesh.vertices.size());
    indices_ = buffer_of(mesh.triangles.data(), mesh.triangles.size());
}

EmbeddedScene::EmbeddedScene(const Wide8& layout)
    : EmbeddedScene("wide8", layout.nodes, layout.blocks, layout.blocks.size()) {}
EmbeddedScene::EmbeddedScene(const Wide4& layout)
    : EmbeddedScene("wide4", layout.nodes, layout.blocks, layout.blocks.size()) {}
EmbeddedScene::EmbeddedScene(const Compressed8& layout)
    : EmbeddedScene("compressed8", layout.nodes, layout.triangles, layout.triangles.size()) {}
EmbeddedScene::EmbeddedScene(const Compressed8& layout, const Mesh& mesh) : EmbeddedScene(layout) {
    set_mesh(mesh);
}
EmbeddedScene::EmbeddedScene(const PairLayout& layout, const Mesh& mesh)
    : EmbeddedScene("pair", layout.nodes, layout.primitive_ids, layout.primitive_ids.size()) {
    set_mesh(mesh);
}
EmbeddedScene::EmbeddedScene(const SkipLayout& layout, const Mesh& mesh)
    : EmbeddedScene("skip", layout.nodes, layout.primitive_ids, layout.nodes.size()) {
    set_mesh(mesh);
}
EmbeddedScene::EmbeddedScene(const Bvh& bvh, const Mesh& mesh)
    : EmbeddedScene("binary", bvh.nodes, bvh.primitive_ids, bvh.primitive_ids.size()) {
    set_mesh(mesh);
}

std::vector<EmbeddedScene> embedded_scenes(const Bvh& bvh, const Mesh& mesh) {
    std::vector<EmbeddedScene> scenes;
    scenes.emplace_back(make_layout<Wide8>(bvh, mesh));
    scenes.emplace_back(make_layout<Wide4>(bvh, mesh));
    scenes.emplace_back(make_layout<Compressed8>(bvh, mesh), mesh);
    scenes.emplace_back(make_layout<PairLayout>(bvh), mesh);
    scenes.emplace_back(make_layout<SkipLayout>(bvh), mesh);
    scenes.emplace_back(bvh, mesh);
    return scenes;
}

Embedded EmbeddedScene::trace(const std::string& options, std::span<const Ray> rays, const User& user) const {
    const std::string layout = " -DCLBVH_LAYOUT=" + layout_ + " -DSCENE_OF=" + layout_ + "_scene ";
    const std::string rounding = device_is_exact() ? " -cl-fp32-correctly-rounded-divide-sqrt " : "";
    static std::map<std::string, cl::Program> programs;
    cl::Program& program = programs[options + layout];
    if (program() == nullptr) program = build_embedded(kKernels, options + layout + rounding);
    const cl::CommandQueue& queue = shared_context().session().queue();
    // Drivers compile kernels for each size of work groups.
    constexpr std::size_t kWorkGroup = 64;
    std::vector<Ray> all_rays(rays.begin(), rays.end());
    all_rays.resize((rays.size() + kWorkGroup - 1) / kWorkGroup * kWorkGroup);
    const cl::Buffer ray_buffer = buffer_of(all_rays.data(), all_rays.size());
    const cl::Buffer user_buffer = buffer_of(user.data(), user.size());
    const auto run = [&](const char* name, auto& results) {
        results.resize(all_rays.size());
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
        set(user_buffer);
        set(buffer);
        queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(all_rays.size()), cl::NDRange(kWorkGroup));
        queue.enqueueReadBuffer(buffer, CL_TRUE, 0, results.size() * sizeof(results[0]), results.data());
        results.resize(rays.size());
    };
    Embedded found;
    run("find_closest", found.closest);
    run("find_any", found.any);
    run("find_all", found.all);
    return found;
}

}  // namespace clbvh::test
