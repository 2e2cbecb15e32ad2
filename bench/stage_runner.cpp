#include "stage_runner.hpp"

#include "catalog/builder_rows.hpp"
#include "clbvh/io/scene.hpp"

namespace clbvh::bench {
namespace {

constexpr const char* kScene = "clustered";

/// One context for all benchmarks, so that every kernel is compiled once.
const Context& shared_context() {
    static const Context context = Context::open();
    return context;
}

cl::Buffer upload(const device::Session& session, const void* data, std::size_t bytes) {
    const cl::Buffer buffer(session.context(), CL_MEM_READ_ONLY, bytes);
    session.queue().enqueueWriteBuffer(buffer, CL_TRUE, 0, bytes, data);
    return buffer;
}

}  // namespace

StageRunner::StageRunner(const BuildOptions& options, std::uint32_t triangles)
    : context_(shared_context()),
      settings_(device::resolve_settings(*find_builder_row("plocpp").device_algorithm, options, context_.session())) {
    const Mesh mesh = generate_scene(kScene, triangles);
    mesh_.vertices = {upload(session(), mesh.vertices.data(), mesh.vertices.size() * sizeof(Vec3))};
    mesh_.indices = {upload(session(), mesh.triangles.data(), mesh.triangles.size() * sizeof(Triangle))};
    mesh_.primitive_count = triangles;
    mesh_.active_count = triangles;
    memory_.reserve(session(), device::plan_memory(settings_, device::BoxOrder::morton, triangles, 0));
}

void StageRunner::run(benchmark::State& state, const Step& prepare, const Step& measured) {
    const ProgressCallback none;
    std::uint64_t bytes = 0;
    const auto run_once = [&] {
        device::Launcher launcher(session(), none);
        launcher.begin_stage("prepare", 0.0);
        prepare(*this, launcher);
        launcher.begin_stage("measured", 0.0);
        measured(*this, launcher);
        const BuildStats stats = launcher.finish();
        bytes = stats.stages.back().bytes_moved;
        return stats.stages.back().device_ms * 1e-3;
    };
    run_once();  // compiles the kernels and touches the memory
    for ([[maybe_unused]] auto iteration : state)
        state.SetIterationTime(run_once());
    const auto iterations = static_cast<std::int64_t>(state.iterations());
    state.SetItemsProcessed(iterations * size());
    state.SetBytesProcessed(iterations * static_cast<std::int64_t>(bytes));
}

}  // namespace clbvh::bench
