#include "rays/trace_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <clbvh/builder.hpp>
#include <clbvh/io/ray_file.hpp>
#include <clbvh/metrics/sah.hpp>
#include <memory>
#include <span>
#include <utility>

#include "cli/interrupt.hpp"
#include "cli/open_builder.hpp"
#include "measure/rounds.hpp"

namespace clbvh::tool {
namespace {

void set_speeds(std::span<TraceResult> results) {
    const auto baseline = std::ranges::find(results, kTraceBaseline, &TraceResult::builder);
    const double nanoseconds = baseline->cost.ns_per_ray();
    for (TraceResult& result : results)
        result.speed = nanoseconds / result.cost.ns_per_ray();
}

}  // namespace

TraceResult describe_candidate(const std::string& scene, const Mesh& mesh, std::string_view builder, BuilderKind kind,
                               const Bvh& bvh) {
    TraceResult base;
    base.scene = scene;
    base.triangles = mesh.triangles.size();
    base.builder = builder;
    base.kind = kind;
    base.sah = sah_cost(bvh);
    return base;
}

TraceCandidate make_candidate(TraceResult base, const Bvh& bvh, const Mesh& mesh, const TraceSettings& settings,
                              const TracerArguments& tracing) {
    base.traced_on = tracing.place(settings.context);
    base.threads = tracing.threads(settings.options);
    return {std::move(base), tracing.engine(bvh, mesh, settings.options, settings.context)};
}

std::vector<TraceCandidate> build_candidates(const TraceSettings& settings, const TracerArguments& tracing,
                                             const std::string& scene, const Mesh& mesh, ProgressBar& bar,
                                             const VisitTree& visit) {
    BuildOptions options = settings.options;
    std::string label;
    options.progress = [&](const Progress& build) {
        bar.show(build.fraction, label);
        return !interrupted();
    };
    std::vector<TraceCandidate> candidates;
    for (const std::string& id : settings.builders) {
        throw_if_interrupted();
        label = fmt::format("{}, building with {}", scene, id);
        bar.show_now(0.0, label);
        const Bvh bvh = open_builder(id, settings.context, options).build(mesh);
        TraceResult base = describe_candidate(scene, mesh, id, find_builder(id).kind, bvh);
        if (visit) visit(base, bvh);
        candidates.push_back(make_candidate(std::move(base), bvh, mesh, settings, tracing));
    }
    return candidates;
}

TraceResult result_of(const TraceResult& base, const RayArguments& arguments, const RaySet& set, const Camera& camera,
                      const RayCost& cost) {
    TraceResult result = base;
    result.rays = set.kind;
    result.seed = arguments.seed;
    result.hash = hash_rays(set.rays);
    result.camera = to_string(camera);
    result.loaded_from = arguments.load_from;
    result.cost = cost;
    return result;
}

std::vector<TraceResult> trace_scene(const TraceSettings& settings, const RayArguments& rays,
                                     const TracerArguments& tracing, const std::string& scene,
                                     const ViewedScene& viewed, ProgressBar& bar) {
    const std::vector<TraceCandidate> candidates = build_candidates(settings, tracing, scene, viewed.mesh, bar);
    std::vector<RayEntrant> entrants;
    entrants.reserve(candidates.size());
    for (const TraceCandidate& candidate : candidates)
        entrants.push_back({candidate.base.builder, candidate.engine.get()});
    std::vector<TraceResult> results;
    for (const RayKind kind : rays.kinds) {
        const std::string title = fmt::format("{}, {} rays", scene, to_string(kind));
        bar.show_now(0.0, title);
        const RaySet set =
            rays.rays(kind, scene, viewed.mesh, closest_hits_of(*entrants.front().engine), viewed.camera);
        RoundsProgress progress(title, bar);
        const std::vector<RayCost> costs =
            measure_rays(entrants, *entrants.front().engine, set, settings.runs, progress);
        for (std::size_t i = 0; i < candidates.size(); ++i)
            results.push_back(result_of(candidates[i].base, rays, set, viewed.unturned_camera, costs[i]));
        set_speeds(std::span(results).last(candidates.size()));
    }
    return results;
}

}  // namespace clbvh::tool
