#include "measure/build_result.hpp"

#include <fmt/core.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <clbvh/core/validate.hpp>
#include <clbvh/metrics/sah.hpp>
#include <clbvh/metrics/surface_ray_cost.hpp>
#include <clbvh/metrics/tree_statistics.hpp>
#include <cstddef>
#include <limits>

#include "cli/complain.hpp"
#include "cli/exit_code.hpp"

namespace clbvh::tool {
namespace {

template <typename Value>
Sample over_runs(std::span<const BuildStats> runs, const Value& value) {
    std::vector<double> values;
    for (const BuildStats& run : runs)
        values.push_back(value(run));
    return summarize(std::move(values));
}

double launch_overhead(const BuildStats& run) {
    double milliseconds = run.build_ms;
    for (const StageStats& stage : run.stages)
        milliseconds -= ran_on_host(stage) ? stage.host_ms : stage.device_ms;
    return std::max(0.0, milliseconds);
}

}  // namespace

double BuildResult::mtris_per_s() const {
    return build_ms.median > 0.0 ? static_cast<double>(triangles) / build_ms.median / 1e3 : 0.0;
}

double BuildResult::peak_bytes_per_primitive() const {
    return triangles > 0 ? static_cast<double>(peak_bytes) / static_cast<double>(triangles) : 0.0;
}

double BuildResult::primitives_per_leaf() const {
    return leaves > 0 ? static_cast<double>(references) / static_cast<double>(leaves) : 0.0;
}

bool ran_on_host(const StageStats& stage) {
    return stage.launches == 0;
}

double gb_per_s(const StageStats& stage) {
    if (stage.device_ms <= 0.0 || stage.bytes_moved == 0) return std::numeric_limits<double>::quiet_NaN();
    return static_cast<double>(stage.bytes_moved) / stage.device_ms * 1e-6;
}

void summarize_runs(BuildResult& result, std::span<const BuildStats> runs) {
    const BuildStats& last = runs.back();
    result.build_ms = over_runs(runs, [](const BuildStats& run) { return run.build_ms; });
    result.stages = last.stages;
    for (std::size_t i = 0; i < result.stages.size(); ++i) {
        StageStats& stage = result.stages[i];
        stage.device_ms = over_runs(runs, [i](const BuildStats& run) { return run.stages.at(i).device_ms; }).median;
        stage.host_ms = over_runs(runs, [i](const BuildStats& run) { return run.stages.at(i).host_ms; }).median;
    }
    result.launch_overhead_ms = over_runs(runs, launch_overhead);
    result.launches = last.launches;
    result.iterations = last.iterations;
    result.peak_bytes = std::max(last.peak_device_bytes, last.peak_host_bytes);
    result.inactive_primitives = last.inactive_primitives;
}

void describe_builder(BuildResult& result, const Builder& builder) {
    result.builder = builder.id();
    result.kind = builder.info().kind;
    const BuildOptions& options = builder.options();
    if (result.kind == BuilderKind::host) result.threads = host_threads(options);
    result.shape = builder.shape();
    result.radius = reads_option(builder.id(), "ploc.search_radius") ? options.ploc.search_radius : 0;
    result.options = {options.optimizers, options.optimize_passes, options.max_leaf_size, options.split_quota};
}

void describe_tree(BuildResult& result, const Bvh& bvh, const Mesh& mesh, bool validated) {
    result.triangles = mesh.triangles.size();
    result.has_tree = true;
    if (validated) {
        const ValidationReport report = validate(bvh, mesh);
        result.valid = report.valid;
        result.validation_error = report.error;
        result.depth = report.depth;
        result.nodes = report.nodes;
        result.leaves = report.leaves;
    }
    // A broken tree may have cycles: no cost of it is defined.
    result.sah = result.ray_cost = std::numeric_limits<double>::quiet_NaN();
    if (!result.valid.value_or(true)) return;
    const TreeStatistics statistics = tree_statistics(bvh);
    result.depth = statistics.depth();
    result.nodes = statistics.nodes;
    result.leaves = statistics.leaves;
    result.references = statistics.references;
    result.sah = sah_cost(bvh);
    result.ray_cost = surface_ray_cost(bvh, mesh).cost;
}

int report_invalid_trees(std::span<const BuildResult> results) {
    int code = kExitSuccess;
    for (const BuildResult& result : results) {
        if (result.valid.value_or(true)) continue;
        complain(fmt::format("the tree of {} over {} is not valid: {}", result.builder, result.scene,
                             result.validation_error));
        if (!result.is_peer) code = kExitInvalidTree;
    }
    return code;
}

std::uint32_t host_threads(const BuildOptions& options) {
    if (options.thread_count == 0) return static_cast<std::uint32_t>(tbb::this_task_arena::max_concurrency());
    const std::size_t most = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    return static_cast<std::uint32_t>(std::min<std::size_t>(options.thread_count, most));
}

std::string threads_text(std::size_t count) {
    return fmt::format("{} thread{}", count, count == 1 ? "" : "s");
}

std::string_view to_string(BuilderKind kind) {
    return kind == BuilderKind::host ? "host" : "device";
}

}  // namespace clbvh::tool
