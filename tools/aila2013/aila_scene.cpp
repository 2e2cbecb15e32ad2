#include "aila2013/aila_scene.hpp"

#include <fmt/format.h>

#include <clbvh/catalog.hpp>
#include <span>
#include <utility>

#include "rays/metrics_scene.hpp"
#include "rays/trace_scene.hpp"

namespace clbvh::tool {
namespace {

/// One scene's trees as rays see them; a tree itself goes when both engines have what they need.
class Trees {
public:
    Trees(const AilaSettings& settings, AilaScene& result)
        : settings_(settings),
          result_(result),
          tracing_{{}, settings.runs, settings.trees.options, settings.trees.context} {
        on_host_.triangle_test = settings.triangle_test;
        on_device_.triangle_test = settings.triangle_test;
        on_device_.on_device = true;
    }

    void add(const AilaBuilder& builder, const Mesh& mesh, ProgressBar& bar) {
        const std::string label = fmt::format("{}, building with {}", result_.name, builder.title);
        const AilaTree tree = build_aila_tree(builder, settings_.trees, mesh, label, bar);
        result_.build_ms.push_back(tree.build_ms);
        const TraceResult base =
            describe_candidate(result_.name, mesh, builder.id, find_builder(builder.builder).kind, tree.bvh);
        result_.host.push_back(describe_metrics(base, tree.bvh, mesh, settings_.epo_samples, bar));
        host_.push_back(make_candidate(base, tree.bvh, mesh, tracing_, on_host_));
        if (!settings_.traces_on_device) return;
        device_.push_back(make_candidate(base, tree.bvh, mesh, tracing_, on_device_));
    }

    void trace(const RayArguments& rays, const ViewedScene& viewed, ProgressBar& bar) {
        const RayKind kind = rays.kinds.front();
        bar.show_now(0.0, fmt::format("{}, {} rays", result_.name, to_string(kind)));
        RayEngine& first = *host_.front().engine;
        const RaySet set = rays.rays(kind, result_.name, viewed.mesh, closest_hits_of(first), viewed.camera);
        const auto measure = [&](std::span<const TraceCandidate> candidates, std::span<MetricsResult> results) {
            measure_candidates(candidates, first, rays, set, viewed.unturned_camera, settings_.runs, bar, results);
        };
        measure(host_, result_.host);
        if (!settings_.traces_on_device) return;
        result_.device = result_.host;  // the trees' own properties are the same
        measure(device_, result_.device);
    }

private:
    const AilaSettings& settings_;
    AilaScene& result_;
    TraceSettings tracing_;
    TracerArguments on_host_;
    TracerArguments on_device_;
    std::vector<TraceCandidate> host_;
    std::vector<TraceCandidate> device_;
};

}  // namespace

AilaScene measure_aila_scene(const AilaSettings& settings, const RayArguments& rays, const std::string& scene,
                             const ViewedScene& viewed, ProgressBar& bar) {
    AilaScene result;
    result.name = scene;
    result.triangles = viewed.mesh.triangles.size();
    result.builders = settings.builders;
    Trees trees(settings, result);
    for (const AilaBuilder& builder : settings.builders)
        trees.add(builder, viewed.mesh, bar);
    trees.trace(rays, viewed, bar);
    return result;
}

}  // namespace clbvh::tool
