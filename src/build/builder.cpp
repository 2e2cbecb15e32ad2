#include "clbvh/builder.hpp"

#include <tbb/task_arena.h>

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "build/backend.hpp"
#include "build/finish_stage.hpp"
#include "build/presplit_stage.hpp"
#include "catalog/optimizer_rows.hpp"
#include "clbvh/catalog.hpp"
#include "clbvh/core/error.hpp"
#include "clbvh/device/context.hpp"
#include "core/arena_size.hpp"
#include "core/memory_errors.hpp"
#include "core/own_group.hpp"
#include "metrics/surface_rays.hpp"

namespace clbvh {
namespace {

void check_for(const BuilderInfo& info, const BuildOptions& options) {
    check_options(options);
    check_optimizers(options.optimizers);
    if (options.optimize_on == OptimizeOn::host || options.optimizers.empty()) return;
    if (info.kind == BuilderKind::host) {
        throw Error(ErrorCode::unsupported, "optimize_on device: " + std::string(info.id) +
                                                " builds its trees on the host; let the host optimize them, or take a "
                                                "device builder");
    }
    check_device_optimizers(options.optimizers);
}

// All checks that need no device come before one is opened.
std::optional<Context> open_context_for(std::string_view builder_id, const BuildOptions& options) {
    const BuilderInfo& info = find_builder(builder_id);
    check_for(info, with_split_of_optimizers(with_preset(builder_id, options)));
    if (info.kind == BuilderKind::host) return std::nullopt;
    return Context::open();
}

/// True where there is work before the builder.
bool needs_splitting(const BuildOptions& options) {
    return options.presplit_level > 0 || options.split_quota > 0.0f;
}

/// True where there is work behind the builder.
bool needs_finish(const BuildOptions& options) {
    return needs_splitting(options) || options.max_leaf_size > 0 || optimizes_on_host(options);
}

/// Does the work of a stage on the host behind a build.
template <typename Work>
void add_stage(BuildStats& stats, const char* name, const Work& work) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - begin;
    StageStats& stage = stats.stages.emplace_back();
    stage.name = name;
    stage.host_ms = time.count();
    stats.build_ms += time.count();
}

/// The builder's part of a build that has stages before and behind it.
struct Share {
    double begin;
    double end;
};
Share share_of_builder(const BuildOptions& options) {
    const double end = optimizes_on_host(options) ? 0.5 : 0.9;
    return {needs_splitting(options) ? 0.1 : 0.0, needs_finish(options) ? end : 1.0};
}

BuildOptions options_of_builder(const BuildOptions& options) {
    BuildOptions result = options;
    if (!options.progress) return result;
    result.progress = [progress = options.progress, share = share_of_builder(options)](const Progress& p) {
        return progress({p.stage, share.begin + p.fraction * (share.end - share.begin)});
    };
    return result;
}

[[noreturn]] void refuse_to_split_boxes(const BuildOptions& options) {
    throw Error(ErrorCode::unsupported, std::string(options.split_quota > 0.0f ? "split_quota" : "presplit_level") +
                                            " splits triangles, but boxes were given: leave it 0, or take the builder "
                                            "sbvh, which splits boxes as well");
}

/// The preset's own id where `builder_id` is one's, else the builder's.
std::string_view canonical_id(std::string_view builder_id, const BuilderRow& row) {
    const PresetInfo* const preset = find_preset(builder_id);
    return preset != nullptr ? preset->id : row.info.id;
}

}  // namespace

struct CLBVH_NO_EXPORT Builder::State {
    State(std::string_view builder_id, std::optional<Context> chosen_context, const BuildOptions& chosen_options)
        : row(find_builder_row(builder_id)),
          id(canonical_id(builder_id, row)),
          context(std::move(chosen_context)),
          options(with_split_of_optimizers(with_preset(builder_id, chosen_options))) {
        check_for(row.info, options);
        backend_options = options_of_builder(options);
        arena.initialize(arena_size(options.thread_count));
        if (row.info.kind == BuilderKind::host) {
            context.reset();
            backend = make_host_backend(row, backend_options, arena);
        } else {
            backend = make_device_backend(row, backend_options, *context, arena);
        }
    }

    void upload(const Primitives& primitives);
    void release_input();
    BuildStats run();
    void with_tree(const std::function<void(const layout::TreeView&)>& read) const;
    void make_layout(const MeshView& mesh, Wide8& result, BuildStats& stats);
    void measure_rays(BuildStats& stats);

    [[nodiscard]] bool is_presplit() const noexcept { return needs_splitting(options); }
    [[nodiscard]] bool is_finished_here() const noexcept { return needs_finish(options); }

    const BuilderRow& row;
    std::string_view id;             // of the row, or of the preset
    std::optional<Context> context;  // absent for host builders
    BuildOptions options;
    BuildOptions backend_options;  // the same, save that progress is a part of the whole
    tbb::task_arena arena;
    std::unique_ptr<Backend> backend;
    PresplitStage presplit{row, options};
    FinishStage finish{options};
    layout::WideConverter<8> converter;
    std::uint64_t primitive_count = 0;
    std::uint64_t inactive_primitives = 0;
    std::optional<MeshView> uploaded_mesh;
    Mesh owned_mesh;  // what upload() was given to keep
    std::vector<Aabb> owned_boxes;
    bool uploaded = false;
    bool finished = false;  // the backend holds a tree over its primitives
};

Builder::Builder(std::string_view builder_id, const BuildOptions& options)
    : state_(std::make_unique<State>(builder_id, open_context_for(builder_id, options), options)) {}

Builder::Builder(std::string_view builder_id, Context context, const BuildOptions& options)
    : state_(std::make_unique<State>(builder_id, std::move(context), options)) {}

Builder::Builder(Builder&&) noexcept = default;
Builder& Builder::operator=(Builder&&) noexcept = default;
Builder::~Builder() = default;

void Builder::State::upload(const Primitives& primitives) {
    finished = false;
    uploaded = false;
    const auto* const mesh = std::get_if<MeshView>(&primitives);
    if (is_presplit() && mesh == nullptr) refuse_to_split_boxes(options);
    inactive_primitives = execute_in(arena, [&] { return check_primitives(primitives); });
    primitive_count = count_of(primitives);
    uploaded_mesh.reset();
    if (is_presplit()) {
        execute_in(arena, [&] { presplit.run(*mesh, share_of_builder(options).begin); });
        backend->upload({BoxView(presplit.boxes()), presplit.boxes().size(), presplit.triangles()});
    } else {
        backend->upload({primitives, primitive_count - inactive_primitives, {}});
    }
    if (mesh != nullptr) uploaded_mesh = *mesh;
    uploaded = true;
}

void Builder::State::release_input() {
    uploaded = false;
    backend->release_input();
    uploaded_mesh.reset();
    owned_mesh = {};
    owned_boxes = {};
}

BuildStats Builder::State::run() {
    finished = false;
    BuildStats stats = backend->run();
    stats.inactive_primitives = inactive_primitives;
    if (is_presplit()) presplit.book(stats);
    if (is_finished_here()) {
        const FinishStage::Input input{primitive_count, presplit.sources(), is_presplit()};
        execute_in(arena, [&] { finish.run(*backend, input, share_of_builder(options).end, stats); });
    }
    finished = true;
    if (options.ray_cost && uploaded_mesh) measure_rays(stats);
    return stats;
}

void Builder::State::with_tree(const std::function<void(const layout::TreeView&)>& read) const {
    if (is_finished_here()) {
        read(layout::view_of(finish.tree()));
    } else {
        backend->with_tree(read);
    }
}

void Builder::State::make_layout(const MeshView& mesh, Wide8& result, BuildStats& stats) {
    add_stage(stats, "wide8", [&] {
        with_tree([&](const layout::TreeView& tree) {
            execute_in(arena, [&] { converter.run(tree, mesh, result, options.opening); });
        });
    });
}

void Builder::State::measure_rays(BuildStats& stats) {
    add_stage(stats, "ray-cost", [&] {
        with_tree([&](const layout::TreeView& tree) {
            stats.ray_cost = execute_in(arena, [&] {
                return trace_surface_rays(tree.nodes, tree.primitive_ids, *uploaded_mesh, kSurfaceRays, {}).cost;
            });
        });
    });
}

void Builder::upload(const Primitives& primitives) {
    with_memory_errors("the uploaded primitives", [&] { state_->upload(primitives); });
    state_->owned_mesh = {};
    state_->owned_boxes = {};
}

void Builder::upload(Mesh&& mesh) {
    state_->release_input();
    state_->owned_mesh = std::move(mesh);
    with_memory_errors("the uploaded primitives", [&] { state_->upload(state_->owned_mesh); });
}

void Builder::upload(std::vector<Aabb>&& boxes) {
    state_->release_input();
    state_->owned_boxes = std::move(boxes);
    with_memory_errors("the uploaded primitives", [&] { state_->upload(state_->owned_boxes); });
}

BuildStats Builder::run() {
    if (!state_->uploaded) {
        throw Error(ErrorCode::invalid_input, "nothing was uploaded; call upload() before run()");
    }
    return with_memory_errors("the build", [&] { return state_->run(); });
}

Bvh Builder::download() const {
    const State& state = *state_;
    if (!state.finished) {
        throw Error(ErrorCode::invalid_input, "there is no finished tree; call run() before download()");
    }
    return with_memory_errors("a copy of the tree", [&] {
        return state.is_finished_here() ? state.finish.tree() : state.backend->download();
    });
}

Bvh Builder::build(const Primitives& primitives, BuildStats* stats) {
    // Whatever happens, no view outlives the call.
    const auto release = [](State* state) { state->release_input(); };
    const std::unique_ptr<State, decltype(release)> guard(state_.get(), release);
    upload(primitives);
    BuildStats result = run();
    if (stats != nullptr) {
        *stats = std::move(result);
    }
    return download();
}

void Builder::build_layout(const MeshView& mesh, Wide8& result, BuildStats* stats) {
    State& state = *state_;
    const auto release = [](State* held) { held->release_input(); };
    const std::unique_ptr<State, decltype(release)> guard(&state, release);
    result.clear();
    upload(mesh);
    BuildStats cost = run();
    with_memory_errors("the layout", [&] { state.make_layout(mesh, result, cost); });
    if (stats != nullptr) *stats = std::move(cost);
}

Tracer Builder::build_tracer(const MeshView& mesh, const TracerOptions& options, BuildStats* stats) {
    Wide8 layout;
    build_layout(mesh, layout, stats);
    return Tracer(std::move(layout), options);
}

const BuilderInfo& Builder::info() const noexcept {
    return state_->row.info;
}
std::string_view Builder::id() const noexcept {
    return state_->id;
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

Bvh build(const Primitives& primitives, std::string_view builder_id, const BuildOptions& options, BuildStats* stats) {
    return Builder(builder_id, options).build(primitives, stats);
}

Tracer build_tracer(const MeshView& mesh, std::string_view builder_id, const BuildOptions& options,
                    const TracerOptions& tracing, BuildStats* stats) {
    return Builder(builder_id, options).build_tracer(mesh, tracing, stats);
}

}  // namespace clbvh
