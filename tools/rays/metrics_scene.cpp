#include "rays/metrics_scene.hpp"

#include <fmt/format.h>

#include <clbvh/metrics/epo.hpp>
#include <clbvh/metrics/surface_ray_cost.hpp>

#include "cli/interrupt.hpp"
#include "cli/stopwatch.hpp"
#include "measure/rounds.hpp"
#include "measure/wide_and_binary.hpp"

namespace clbvh::tool {
MetricsResult describe_metrics(const TraceResult& base, const Bvh& bvh, const Mesh& mesh, std::uint64_t epo_samples,
                               ProgressBar& bar) {
    const std::string label = fmt::format("{}, end-point overlap of {}", base.scene, base.builder);
    bar.show_now(0.0, label);
    MetricsResult result;
    result.trace = base;
    result.statistics = tree_statistics(bvh);
    result.ray_cost = surface_ray_cost(bvh, mesh).cost;
    const Stopwatch stopwatch;
    if (epo_samples > 0) {
        const Estimate estimate = end_point_overlap_sampled(bvh, mesh, epo_samples);
        result.epo = estimate.value;
        result.epo_error = estimate.standard_error;
    } else {
        result.epo = end_point_overlap(bvh, mesh, {}, [&](const Progress& progress) {
            bar.show(progress.fraction, label);
            return !interrupted();
        });
    }
    result.epo_ms = stopwatch.milliseconds();
    return result;
}

void measure_candidates(std::span<const TraceCandidate> candidates, RayEngine& reference, const RayArguments& rays,
                        const RaySet& set, const Camera& unturned_camera, std::size_t runs, ProgressBar& bar,
                        std::span<MetricsResult> results) {
    const TraceResult& first = candidates.front().base;
    const std::string title = fmt::format("{}, {} rays on {}", first.scene, to_string(set.kind), first.traced_on);
    RoundsProgress progress(title, bar);
    WideAndBinary field;
    for (const TraceCandidate& candidate : candidates)
        field.add(candidate.base.builder, *candidate.engine);
    field.measure(reference, set, runs, progress);
    for (std::size_t i = 0; i < results.size(); ++i) {
        results[i].trace = result_of(candidates[i].base, rays, set, unturned_camera, field.cost(i));
        results[i].binary_trace_ms = field.binary_cost(i).trace_ms;
    }
}

std::vector<MetricsResult> measure_scene(const MetricsSettings& settings, const RayArguments& rays,
                                         const TracerArguments& tracing, const std::string& scene,
                                         const ViewedScene& viewed, ProgressBar& bar) {
    std::vector<MetricsResult> results;
    const auto visit = [&](const TraceResult& base, const Bvh& bvh) {
        results.push_back(describe_metrics(base, bvh, viewed.mesh, settings.epo_samples, bar));
    };
    const std::vector<TraceCandidate> candidates =
        build_candidates(settings.tracing, tracing, scene, viewed.mesh, bar, visit);
    const RayKind kind = rays.kinds.front();
    bar.show_now(0.0, fmt::format("{}, {} rays", scene, to_string(kind)));
    RayEngine& first = *candidates.front().engine;
    const RaySet set = rays.rays(kind, scene, viewed.mesh, closest_hits_of(first), viewed.camera);
    measure_candidates(candidates, first, rays, set, viewed.unturned_camera, settings.tracing.runs, bar, results);
    return results;
}

}  // namespace clbvh::tool
