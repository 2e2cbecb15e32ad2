#include "trace_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <clbvh/builder.hpp>
#include <clbvh/io/ray_file.hpp>
#include <clbvh/metrics/sah.hpp>
#include <memory>
#include <span>
#include <utility>

#include "interrupt.hpp"
#include "open_builder.hpp"
#include "rounds.hpp"

namespace clbvh::tool {
namespace {

/// A tree that takes part.
struct Candidate {
    TraceResult base;  ///< What is the same for all rays.
    std::unique_ptr<RayEngine> engine;
};

std::vector<Candidate> build_candidates(const TraceSettings& settings, const TracerArguments& tracing,
                                        const std::string& scene, const Mesh& mesh, ProgressBar& bar) {
    BuildOptions options = settings.options;
    std::string label;
    options.progress = [&](const Progress& build) {
        bar.show(build.fraction, label);
        return !interrupted();
    };
    std::vector<Candidate> candidates;
    for (const std::string& id : settings.builders) {
        throw_if_interrupted();
        label = fmt::format("{}, building with {}", scene, id);
        bar.show_now(0.0, label);
        const Bvh bvh = open_builder(id, settings.context, options).build(mesh);
        Candidate candidate;
        candidate.base.scene = scene;
        candidate.base.triangles = mesh.triangles.size();
        candidate.base.builder = id;
        candidate.base.kind = find_builder(id).kind;
        candidate.base.sah = sah_cost(bvh);
        candidate.base.traced_on = tracing.place(settings.context);
        candidate.base.threads = tracing.threads(options);
        candidate.engine = tracing.engine(bvh, mesh, options, settings.context);
        candidates.push_back(std::move(candidate));
    }
    return candidates;
}

void set_speeds(std::span<TraceResult> results) {
    const auto baseline = std::ranges::find(results, kTraceBaseline, &TraceResult::builder);
    const double nanoseconds = baseline->cost.ns_per_ray();
    for (TraceResult& result : results)
        result.speed = nanoseconds / result.cost.ns_per_ray();
}

}  // namespace

std::vector<TraceResult> trace_scene(const TraceSettings& settings, const RayArguments& rays,
                                     const TracerArguments& tracing, const std::string& scene,
                                     const ViewedScene& viewed, ProgressBar& bar) {
    const std::vector<Candidate> candidates = build_candidates(settings, tracing, scene, viewed.mesh, bar);
    std::vector<RayEntrant> entrants;
    for (const Candidate& candidate : candidates)
        entrants.push_back({candidate.base.builder, candidate.engine.get()});
    std::vector<TraceResult> results;
    for (const RayKind kind : rays.kinds) {
        const std::string title = fmt::format("{}, {} rays", scene, to_string(kind));
        bar.show_now(0.0, title);
        const RaySet set =
            rays.rays(kind, scene, viewed.mesh, closest_hits_of(*entrants.front().engine), viewed.camera);
        RoundsProgress progress(title, bar);
        const std::vector<RayCost> costs = measure_rays(entrants, set, settings.runs, progress);
        for (std::size_t i = 0; i < candidates.size(); ++i) {
            TraceResult& result = results.emplace_back(candidates[i].base);
            result.rays = kind;
            result.seed = rays.seed;
            result.hash = hash_rays(set.rays);
            result.camera = to_string(viewed.camera);
            result.loaded_from = rays.load_from;
            result.cost = costs[i];
        }
        set_speeds(std::span(results).last(candidates.size()));
    }
    return results;
}

}  // namespace clbvh::tool
