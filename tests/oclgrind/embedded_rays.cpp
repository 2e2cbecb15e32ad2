// Rays through each layout in kernels that are not the library's own, beside the host's: what Oclgrind watches.

#define CL_HPP_ENABLE_EXCEPTIONS
#define CL_HPP_MINIMUM_OPENCL_VERSION 120
#define CL_HPP_TARGET_OPENCL_VERSION 120
#include <CL/opencl.hpp>
#include <clbvh/clbvh.hpp>
#include <clbvh/io/scene.hpp>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

namespace {

constexpr const char* kKernel = R"(
__kernel void trace(__global const NODES* nodes, __global const LEAVES* leaves, uint count MESH_ARGUMENTS,
                    __global const float4* rays, __global float4* hits, __global uint2* counts) {
    const clbvh_scene scene = {nodes, leaves, count MESH};
    const size_t i = get_global_id(0);
    const clbvh_ray ray = clbvh_load_ray(rays, i);
    clbvh_store_hit(hits, i, clbvh_closest(scene, ray, 0));
    clbvh_hit some[2], last = CLBVH_FIRST;
    uint all = 0;
    for (uint found = 2; found == 2; all += found) {
        found = clbvh_all(scene, ray, last, some, 2, 0);
        if (found > 0) last = some[found - 1];
    }
    counts[i] = (uint2)(clbvh_any(scene, ray, 0) ? 1 : 0, all);
}
)";

/// From vertices scaled up by a third to other vertices.
std::vector<clbvh::Ray> rays_through(const clbvh::Mesh& mesh) {
    std::vector<clbvh::Ray> rays;
    for (std::size_t i = 0; i < 32; ++i) {
        const clbvh::Vec3& from = mesh.vertices[i * 7 % mesh.vertices.size()];
        const clbvh::Vec3& to = mesh.vertices[i * 31 % mesh.vertices.size()];
        const clbvh::Vec3 origin{1.3f * from.x, 1.3f * from.y, from.z};
        rays.push_back({origin, 0.0f, {to.x - origin.x, to.y - origin.y, to.z - origin.z}});
    }
    return rays;
}

class Embedded {
public:
    Embedded(const clbvh::Bvh& bvh, const clbvh::Mesh& mesh)
        : mesh_(mesh), rays_(rays_through(mesh)), expected_(rays_.size()) {
        const clbvh::Tracer tracer(bvh, mesh);
        tracer.closest(rays_, expected_);
        const clbvh::HitLists all = tracer.all(rays_);
        for (std::size_t i = 0; i < rays_.size(); ++i) {
            const auto count = static_cast<cl_uint>(all.begins[i + 1] - all.begins[i]);
            expected_counts_.push_back({{count > 0 ? 1U : 0U, count}});
        }
    }

    /// Whether hits are the host's. `count` is what the scene's third member is.
    template <typename Nodes, typename Leaves>
    bool check(const std::string& layout, const std::string& types, const Nodes& nodes, const Leaves& leaves,
               std::size_t count, bool has_mesh) const {
        const std::string mesh =
            has_mesh ? "#define MESH , vertices, indices\n"
                       "#define MESH_ARGUMENTS , __global const float* vertices, __global const uint* indices\n"
                     : "#define MESH\n#define MESH_ARGUMENTS\n";
        const cl::Program program(context_, std::string(clbvh::embed_source()) + mesh + kKernel);
        program.build(("-cl-fp32-correctly-rounded-divide-sqrt -DCLBVH_LAYOUT=" + layout + types).c_str());
        cl::Kernel kernel(program, "trace");
        cl_uint argument = 0;
        const auto set = [&](const auto& value) { kernel.setArg(argument++, value); };
        const cl::Buffer hits(context_, CL_MEM_WRITE_ONLY, rays_.size() * sizeof(clbvh::Hit));
        const cl::Buffer counts(context_, CL_MEM_WRITE_ONLY, rays_.size() * sizeof(cl_uint2));
        // A kernel does not keep its buffers.
        const std::vector<cl::Buffer> inputs{buffer_of(nodes), buffer_of(leaves), buffer_of(mesh_.vertices),
                                             buffer_of(mesh_.triangles), buffer_of(rays_)};
        set(inputs[0]);
        set(inputs[1]);
        set(static_cast<cl_uint>(count));
        if (has_mesh) {
            set(inputs[2]);
            set(inputs[3]);
        }
        set(inputs[4]);
        set(hits);
        set(counts);
        const cl::CommandQueue queue(context_);
        queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(rays_.size()), cl::NDRange(8));
        std::vector<clbvh::Hit> found(rays_.size());
        std::vector<cl_uint2> found_counts(rays_.size());
        queue.enqueueReadBuffer(hits, CL_TRUE, 0, found.size() * sizeof(clbvh::Hit), found.data());
        queue.enqueueReadBuffer(counts, CL_TRUE, 0, found.size() * sizeof(cl_uint2), found_counts.data());
        bool are_same = found == expected_;
        for (std::size_t i = 0; i < found.size(); ++i)
            are_same = are_same && found_counts[i].s[0] == expected_counts_[i].s[0] &&
                       found_counts[i].s[1] == expected_counts_[i].s[1];
        if (!are_same) std::cerr << layout << ": hits are not the host's\n";
        return are_same;
    }

private:
    template <typename Array>
    [[nodiscard]] cl::Buffer buffer_of(const Array& array) const {
        return {context_, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, array.size() * sizeof(array[0]),
                const_cast<void*>(static_cast<const void*>(array.data()))};
    }

    const clbvh::Mesh& mesh_;
    std::vector<clbvh::Ray> rays_;
    std::vector<clbvh::Hit> expected_;
    std::vector<cl_uint2> expected_counts_;
    cl::Context context_{CL_DEVICE_TYPE_ALL};
};

int run() {
    const clbvh::Mesh mesh = clbvh::generate_scene("soup", 200);
    const clbvh::Bvh bvh = clbvh::build(mesh, "binned-sah");
    const Embedded embedded(bvh, mesh);
    const auto wide8 = clbvh::make_layout<clbvh::Wide8>(bvh, mesh);
    const auto wide4 = clbvh::make_layout<clbvh::Wide4>(bvh, mesh);
    const auto compressed8 = clbvh::make_layout<clbvh::Compressed8>(bvh, mesh);
    const auto pair = clbvh::make_layout<clbvh::PairLayout>(bvh);
    const auto skip = clbvh::make_layout<clbvh::SkipLayout>(bvh);
    const std::string ids = " -DNODES=float4 -DLEAVES=uint";
    const bool are_same =
        embedded.check("wide8", " -DNODES=float8 -DLEAVES=float4", wide8.nodes, wide8.blocks, wide8.blocks.size(),
                       false) &&
        embedded.check("wide4", " -DNODES=float4 -DLEAVES=float4", wide4.nodes, wide4.blocks, wide4.blocks.size(),
                       false) &&
        embedded.check("compressed8", " -DNODES=uint4 -DLEAVES=float4", compressed8.nodes, compressed8.triangles,
                       compressed8.triangles.size(), true) &&
        embedded.check("pair", ids, pair.nodes, pair.primitive_ids, pair.primitive_ids.size(), true) &&
        embedded.check("skip", ids, skip.nodes, skip.primitive_ids, skip.nodes.size(), true) &&
        embedded.check("binary", ids, bvh.nodes, bvh.primitive_ids, bvh.primitive_ids.size(), true);
    return are_same ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace

int main() {
    try {
        return run();
    } catch (const cl::BuildError& error) {
        std::cerr << error.getBuildLog().front().second << '\n';
    } catch (const std::exception& error) {
        std::cerr << error.what() << '\n';
    }
    return EXIT_FAILURE;
}
