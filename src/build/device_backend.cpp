#include "build/backend.hpp"
#include "catalog/device_configs.hpp"
#include "catalog/device_optimizers.hpp"
#include "device/build/pipeline.hpp"
#include "device/opencl/session.hpp"

namespace clbvh {
namespace {

using device::with_opencl_errors;

// Uploads `bytes` from `data`; an empty array becomes a null buffer, which no kernel is given.
cl::Buffer upload_array(device::Session& session, const void* data, std::size_t bytes) {
    if (bytes == 0) {
        return {};
    }
    cl::Buffer buffer(session.context(), CL_MEM_READ_ONLY, bytes);
    session.queue().enqueueWriteBuffer(buffer, CL_TRUE, 0, bytes, data);
    return buffer;
}

class DeviceBackend final : public Backend {
public:
    DeviceBackend(const BuilderRow& row, const BuildOptions& options, const Context& context)
        : algorithm_(*row.device_algorithm),
          options_(options),
          context_(context),
          settings_(
              device::prepare_pipeline(context_.session(), algorithm_, device_configs_for(row.info.id, options))) {
        if (options.optimize_on == OptimizeOn::device) {
            optimizers_ = make_optimizer_chain(context_.session(), options);
        }
    }

    void upload(const Mesh& mesh, std::uint64_t active_count) override {
        device::Session& session = context_.session();
        mesh_ = {};  // the memory of the mesh before is free again
        const auto primitives = static_cast<std::uint32_t>(mesh.triangles.size());
        if (primitives > 0) {
            device::check_allocations(session, device::plan_pipeline(algorithm_, settings_, primitives),
                                      optimizers_.scratch_bytes(2 * static_cast<std::uint32_t>(active_count)));
        }
        device::DeviceMesh uploaded;
        uploaded.primitive_count = primitives;
        uploaded.active_count = static_cast<std::uint32_t>(active_count);
        with_opencl_errors("uploading the mesh", [&] {
            uploaded.vertices = upload_array(session, mesh.vertices.data(), mesh.vertices.size() * sizeof(Vec3));
            uploaded.triangles = upload_array(session, mesh.triangles.data(), mesh.triangles.size() * sizeof(Triangle));
        });
        mesh_ = uploaded;
    }

    BuildStats run() override {
        return device::run_pipeline(context_.session(), algorithm_, settings_, options_.progress, mesh_, memory_,
                                    optimizers_);
    }

    void upload_parts(const Mesh& boxes, const Mesh&) override { upload(boxes, boxes.triangles.size()); }

    Bvh download() const override {
        Bvh bvh;
        read_tree(bvh);
        return bvh;
    }

    Bvh& tree() override {
        read_tree(downloaded_);
        return downloaded_;
    }
    bool is_remote() const noexcept override { return true; }

    Shape shape() const noexcept override { return settings_.shape; }

private:
    void read_tree(Bvh& bvh) const {
        const std::size_t leaf_count = mesh_.active_count;
        bvh.primitive_count = mesh_.primitive_count;
        bvh.split_references = false;
        bvh.nodes.resize(2 * leaf_count);
        bvh.primitive_ids.resize(leaf_count);
        if (leaf_count == 0) return;
        with_opencl_errors("downloading the tree", [&] {
            const cl::CommandQueue& queue = context_.session().queue();
            queue.enqueueReadBuffer(memory_.buffers().nodes, CL_TRUE, 0, bvh.nodes.size() * sizeof(Node),
                                    bvh.nodes.data());
            queue.enqueueReadBuffer(memory_.buffers().primitive_ids, CL_TRUE, 0, leaf_count * sizeof(std::uint32_t),
                                    bvh.primitive_ids.data());
        });
    }

    const device::DeviceAlgorithm& algorithm_;
    const BuildOptions& options_;
    Context context_;
    device::BuildSettings settings_;
    device::OwnMemory memory_;
    device::OptimizerChain optimizers_;
    device::DeviceMesh mesh_;
    Bvh downloaded_;
};

}  // namespace

std::unique_ptr<Backend> make_device_backend(const BuilderRow& row, const BuildOptions& options,
                                             const Context& context) {
    return std::make_unique<DeviceBackend>(row, options, context);
}

}  // namespace clbvh
