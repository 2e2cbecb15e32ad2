#include "clbvh/builder.hpp"

#include <optional>

#include "backend.hpp"
#include "clbvh/core/error.hpp"

namespace clbvh {
namespace {

// What needs no device is checked before one is opened.
std::optional<Context> open_context_for(std::string_view builder_id, const BuildOptions& options) {
    const BuilderInfo& info = find_builder(builder_id);
    check_options(options);
    if (info.kind == BuilderKind::host) return std::nullopt;
    return Context::open();
}

}  // namespace

struct Builder::State {
    State(std::string_view builder_id, std::optional<Context> chosen_context, const BuildOptions& chosen_options)
        : row(find_builder_row(builder_id)), context(std::move(chosen_context)), options(chosen_options) {
        check_options(options);
        if (row.info.kind == BuilderKind::host) {
            context.reset();
            backend = make_host_backend(row, options);
        } else {
            backend = make_device_backend(row, options, *context);
        }
    }

    const BuilderRow& row;
    std::optional<Context> context;  // absent for host builders
    BuildOptions options;
    std::unique_ptr<Backend> backend;
    bool uploaded = false;
    bool finished = false;  // the backend holds a tree over its mesh
};

Builder::Builder(std::string_view builder_id, const BuildOptions& options)
    : state_(std::make_unique<State>(builder_id, open_context_for(builder_id, options), options)) {}

Builder::Builder(std::string_view builder_id, Context context, const BuildOptions& options)
    : state_(std::make_unique<State>(builder_id, std::move(context), options)) {}

Builder::Builder(Builder&&) noexcept = default;
Builder& Builder::operator=(Builder&&) noexcept = default;
Builder::~Builder() = default;

void Builder::upload(const Mesh& mesh) {
    State& state = *state_;
    const std::uint64_t inactive = check_mesh(mesh);
    state.finished = false;
    state.uploaded = false;
    state.backend->upload(mesh, mesh.triangles.size() - inactive);
    state.uploaded = true;
}

BuildStats Builder::run() {
    State& state = *state_;
    if (!state.uploaded) {
        throw Error(ErrorCode::invalid_input, "nothing was uploaded; call upload() before run()");
    }
    state.finished = false;
    BuildStats stats = state.backend->run();
    state.finished = true;
    return stats;
}

Bvh Builder::download() const {
    const State& state = *state_;
    if (!state.finished) {
        throw Error(ErrorCode::invalid_input, "there is no finished tree; call run() before download()");
    }
    return state.backend->download();
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
const Context& Builder::context() const {
    if (!state_->context) {
        throw Error(ErrorCode::unsupported, std::string(info().id) + " runs on the host and has no OpenCL context");
    }
    return *state_->context;
}
Shape Builder::shape() const noexcept {
    return state_->backend->shape();
}

Bvh build(const Mesh& mesh, std::string_view builder_id, const BuildOptions& options, BuildStats* stats) {
    return Builder(builder_id, options).build(mesh, stats);
}

}  // namespace clbvh
