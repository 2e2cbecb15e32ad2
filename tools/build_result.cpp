#include "build_result.hpp"

#include <fmt/core.h>

#include <clbvh/core/validate.hpp>
#include <clbvh/metrics/sah.hpp>
#include <cstddef>
#include <limits>

#include "exit_code.hpp"
#include "tree_extent.hpp"

namespace clbvh::tool {
namespace {

template <typename Value>
Sample over_runs(std::span<const BuildStats> runs, const Value& value) {
    std::vector<double> values;
    for (const BuildStats& run : runs)
        values.push_back(value(run));
    return summarize(std::move(values));
}

}  // namespace

double BuildResult::mtris_per_s() const {
    return build_ms.median > 0.0 ? static_cast<double>(triangles) / build_ms.median / 1e3 : 0.0;
}

double BuildResult::peak_bytes_per_primitive() const {
    return triangles > 0 ? static_cast<double>(peak_device_bytes) / static_cast<double>(triangles) : 0.0;
}

BuildResult summarize_runs(const Builder& builder, std::string_view scene, const Mesh& mesh,
                           std::span<const BuildStats> runs) {
    const BuildStats& last = runs.back();
    BuildResult result;
    result.scene = scene;
    result.triangles = mesh.triangles.size();
    result.builder = builder.info().id;
    result.shape = builder.shape();
    result.radius = builder.info().uses_search_radius ? builder.options().search_radius : 0;
    result.build_ms = over_runs(runs, [](const BuildStats& run) { return run.build_ms; });
    result.stages = last.stages;
    for (std::size_t i = 0; i < result.stages.size(); ++i) {
        StageStats& stage = result.stages[i];
        stage.device_ms = over_runs(runs, [i](const BuildStats& run) { return run.stages.at(i).device_ms; }).median;
        stage.host_ms = over_runs(runs, [i](const BuildStats& run) { return run.stages.at(i).host_ms; }).median;
    }
    result.launches = last.launches;
    result.iterations = last.iterations;
    result.peak_device_bytes = last.peak_device_bytes;
    result.inactive_primitives = last.inactive_primitives;
    return result;
}

void describe_tree(BuildResult& result, const Bvh& bvh, const Mesh& mesh, bool validated) {
    if (validated) {
        const ValidationReport report = validate(bvh, mesh);
        result.valid = report.valid;
        result.validation_error = report.error;
        result.depth = report.depth;
        result.nodes = report.nodes;
        result.leaves = report.leaves;
    } else {
        const TreeExtent extent = measure_extent(bvh);
        result.depth = extent.depth;
        result.nodes = extent.nodes;
        result.leaves = extent.leaves;
    }
    // A broken tree may have cycles: no cost of it is defined.
    result.sah = result.valid.value_or(true) ? sah_cost(bvh) : std::numeric_limits<double>::quiet_NaN();
}

int report_invalid_trees(std::span<const BuildResult> results) {
    int code = kExitSuccess;
    for (const BuildResult& result : results) {
        if (result.valid.value_or(true)) continue;
        fmt::print(stderr, "clbvh: the tree of {} over {} is not valid: {}\n", result.builder, result.scene,
                   result.validation_error);
        code = kExitInvalidTree;
    }
    return code;
}

}  // namespace clbvh::tool
