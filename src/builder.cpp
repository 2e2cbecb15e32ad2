#include "clbvh/builder.hpp"

#include <optional>

#include "clbvh/core/error.hpp"
#include "device/pipeline.hpp"
#include "device/session.hpp"
#include "registry_rows.hpp"

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

// What needs no device is checked before one is opened.
Context open_default_device(std::string_view builder_id, const BuildOptions& options) {
    static_cast<void>(find_builder(builder_id));
    check_options(options);
    return Context::open();
}

}  // namespace

struct Builder::State {
    const BuilderRow& row;
    Context context;
    BuildOptions options;
    device::BuildSettings settings;
    device::BuildBuffers buffers;
    std::optional<device::DeviceMesh> mesh;
    bool finished = false;  // buffers hold a tree over `mesh`
};

Builder::Builder(std::string_view builder_id, const BuildOptions& options)
    : Builder(builder_id, open_default_device(builder_id, options), options) {}

Builder::Builder(std::string_view builder_id, Context context, const BuildOptions& options) {
    const BuilderRow& row = find_builder_row(builder_id);
    const device::BuildSettings settings = device::resolve_settings(options, context.session());
    state_ = std::make_unique<State>(State{row, std::move(context), options, settings, {}, std::nullopt, false});
}

Builder::Builder(Builder&&) noexcept = default;
Builder& Builder::operator=(Builder&&) noexcept = default;
Builder::~Builder() = default;

void Builder::upload(const Mesh& mesh) {
    State& state = *state_;
    const std::uint64_t inactive = check_mesh(mesh);
    state.finished = false;
    state.mesh.reset();
    device::Session& session = state.context.session();
    device::DeviceMesh uploaded;
    uploaded.primitive_count = static_cast<std::uint32_t>(mesh.triangles.size());
    uploaded.active_count = static_cast<std::uint32_t>(mesh.triangles.size() - inactive);
    with_opencl_errors("uploading the mesh", [&] {
        uploaded.vertices = upload_array(session, mesh.vertices.data(), mesh.vertices.size() * sizeof(Vec3));
        uploaded.triangles = upload_array(session, mesh.triangles.data(), mesh.triangles.size() * sizeof(Triangle));
    });
    state.mesh = uploaded;
}

BuildStats Builder::run() {
    State& state = *state_;
    if (!state.mesh) {
        throw Error(ErrorCode::invalid_input, "nothing was uploaded; call upload() before run()");
    }
    state.finished = false;
    BuildStats stats = device::run_pipeline(state.context.session(), *state.row.device_algorithm, state.settings,
                                            state.options.progress, *state.mesh, state.buffers);
    state.finished = true;
    return stats;
}

Bvh Builder::download() const {
    const State& state = *state_;
    if (!state.finished) {
        throw Error(ErrorCode::invalid_input, "there is no finished tree; call run() before download()");
    }
    Bvh bvh;
    bvh.primitive_count = state.mesh->primitive_count;
    const std::size_t leaf_count = state.mesh->active_count;
    if (leaf_count > 0) {
        bvh.nodes.resize(2 * leaf_count);
        bvh.primitive_ids.resize(leaf_count);
        with_opencl_errors("downloading the tree", [&] {
            const cl::CommandQueue& queue = state.context.session().queue();
            queue.enqueueReadBuffer(state.buffers.nodes, CL_TRUE, 0, bvh.nodes.size() * sizeof(Node), bvh.nodes.data());
            queue.enqueueReadBuffer(state.buffers.primitive_ids, CL_TRUE, 0, leaf_count * sizeof(std::uint32_t),
                                    bvh.primitive_ids.data());
        });
    }
    return bvh;
}

Bvh Builder::build(const Mesh& mesh, BuildStats* stats) {
    upload(mesh);
    BuildStats result = run();
    if (stats != nullptr) {
        *stats = std::move(result);
    }
    return download();
}

const BuilderInfo& Builder::info() const noexcept {
    return state_->row.info;
}
const BuildOptions& Builder::options() const noexcept {
    return state_->options;
}
const Context& Builder::context() const noexcept {
    return state_->context;
}
Shape Builder::shape() const noexcept {
    return state_->settings.shape;
}

Bvh build(const Mesh& mesh, std::string_view builder_id, const BuildOptions& options, BuildStats* stats) {
    return Builder(builder_id, options).build(mesh, stats);
}

}  // namespace clbvh
