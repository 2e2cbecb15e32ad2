#include <utility>

#include "build/backend.hpp"
#include "catalog/device_configs.hpp"
#include "catalog/device_optimizers.hpp"
#include "core/own_group.hpp"
#include "device/build/pipeline.hpp"
#include "device/opencl/host_primitives.hpp"
#include "device/opencl/session.hpp"

namespace clbvh {
namespace {

using device::with_opencl_errors;

class DeviceBackend final : public Backend {
public:
    DeviceBackend(const BuilderRow& row, const BuildOptions& options, Context context, tbb::task_arena& arena)
        : algorithm_(*row.device_algorithm),
          options_(options),
          arena_(arena),
          context_(std::move(context)),
          settings_(
              device::prepare_pipeline(context_.session(), algorithm_, device_configs_for(row.info.id, options))) {
        if (options.optimize_on == OptimizeOn::device) {
            optimizers_ = make_optimizer_chain(context_.session(), options);
        }
    }

    void upload(const Input& input) override {
        device::Session& session = context_.session();
        mesh_ = {};  // the memory of what was uploaded before is free again
        const auto primitives = static_cast<std::uint32_t>(count_of(input.primitives));
        if (primitives > 0) {
            device::check_allocations(session, device::plan_pipeline(algorithm_, settings_, primitives),
                                      optimizers_.scratch_bytes(2 * static_cast<std::uint32_t>(input.active_count)));
        }
        mesh_ = with_opencl_errors("uploading the primitives", [&] {
            return device::bind_primitives(session, input.primitives, input.active_count);
        });
    }

    void release_input() override {
        mesh_.vertices = {};
        mesh_.indices = {};
    }

    BuildStats run() override {
        const auto build = [&] {
            return device::run_pipeline(context_.session(), algorithm_, settings_, options_.progress, mesh_, memory_,
                                        optimizers_);
        };
        return algorithm_.uses_host ? execute_in(arena_, build) : build();
    }

    void with_tree(const std::function<void(const layout::TreeView&)>& read) override {
        if (reads_in_place()) {
            const MappedTree tree(*this);
            read({tree.nodes(), tree.primitive_ids(), mesh_.primitive_count});
        } else {
            read(layout::view_of(this->tree()));
        }
    }

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
    /// The tree in the device's memory, made readable for the host; on CPU devices that moves nothing.
    class MappedTree {
    public:
        explicit MappedTree(const DeviceBackend& backend) : backend_(backend) {
            if (backend.mesh_.active_count == 0) return;
            with_opencl_errors("reading the tree", [&] {
                const device::BuildBuffers& buffers = backend.memory_.buffers();
                node_count_ = 2 * std::size_t{backend.leaf_count()};
                id_count_ = backend.mesh_.active_count;
                nodes_ = map(buffers.nodes, node_count_ * sizeof(Node));
                primitive_ids_ = map(buffers.primitive_ids, id_count_ * sizeof(std::uint32_t));
            });
        }
        MappedTree(const MappedTree&) = delete;
        MappedTree& operator=(const MappedTree&) = delete;
        ~MappedTree() {
            const device::BuildBuffers& buffers = backend_.memory_.buffers();
            unmap(buffers.primitive_ids, primitive_ids_);
            unmap(buffers.nodes, nodes_);
        }

        [[nodiscard]] std::span<const Node> nodes() const noexcept {
            return {static_cast<const Node*>(nodes_), node_count_};
        }
        [[nodiscard]] std::span<const std::uint32_t> primitive_ids() const noexcept {
            return {static_cast<const std::uint32_t*>(primitive_ids_), id_count_};
        }

    private:
        [[nodiscard]] const cl::CommandQueue& queue() const { return backend_.context_.session().queue(); }
        [[nodiscard]] void* map(const cl::Buffer& buffer, std::size_t bytes) const {
            return queue().enqueueMapBuffer(buffer, CL_TRUE, CL_MAP_READ, 0, bytes);
        }
        /// A destructor has nobody to tell of a failure, and nothing is lost by one.
        void unmap(const cl::Buffer& buffer, void* mapped) const noexcept {
            if (mapped != nullptr) clEnqueueUnmapMemObject(queue()(), buffer(), mapped, 0, nullptr, nullptr);
        }

        const DeviceBackend& backend_;
        std::size_t node_count_ = 0;
        std::size_t id_count_ = 0;
        void* nodes_ = nullptr;
        void* primitive_ids_ = nullptr;
    };

    [[nodiscard]] bool reads_in_place() const { return context_.session().info().type == DeviceType::cpu; }

    void read_tree(Bvh& bvh) const {
        bvh.primitive_count = mesh_.primitive_count;
        bvh.split_references = false;
        if (reads_in_place()) {
            // Copied as the vectors grow: to fill them with zeros first takes as long again.
            const MappedTree tree(*this);
            bvh.nodes.assign(tree.nodes().begin(), tree.nodes().end());
            bvh.primitive_ids.assign(tree.primitive_ids().begin(), tree.primitive_ids().end());
            return;
        }
        bvh.primitive_ids.resize(mesh_.active_count);
        if (mesh_.active_count == 0) {
            bvh.nodes.clear();
            return;
        }
        with_opencl_errors("downloading the tree", [&] {
            bvh.nodes.resize(2 * std::size_t{leaf_count()});
            read(memory_.buffers().nodes, bvh.nodes);
            read(memory_.buffers().primitive_ids, bvh.primitive_ids);
        });
    }

    /// Of the tree on the device.
    [[nodiscard]] std::uint32_t leaf_count() const {
        if (!settings_.groups_primitives()) return mesh_.active_count;
        std::vector<std::uint32_t> count(1);
        read(memory_.buffers().leaf_count, count);
        return count[0];
    }

    template <typename T>
    void read(const cl::Buffer& buffer, std::vector<T>& values) const {
        context_.session().queue().enqueueReadBuffer(buffer, CL_TRUE, 0, values.size() * sizeof(T), values.data());
    }

    const device::DeviceAlgorithm& algorithm_;
    const BuildOptions& options_;
    tbb::task_arena& arena_;
    Context context_;
    device::BuildSettings settings_;
    device::OwnMemory memory_;
    device::OptimizerChain optimizers_;
    device::DeviceMesh mesh_;
    Bvh downloaded_;
};

}  // namespace

std::unique_ptr<Backend> make_device_backend(const BuilderRow& row, const BuildOptions& options, const Context& context,
                                             tbb::task_arena& arena) {
    return std::make_unique<DeviceBackend>(row, options, context, arena);
}

}  // namespace clbvh
