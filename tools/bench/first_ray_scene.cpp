#include "bench/first_ray_scene.hpp"

#include <algorithm>
#include <clbvh/builder.hpp>
#include <clbvh/eval/ray_sets.hpp>
#include <clbvh/trace/tracer.hpp>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>

#include "cli/interrupt.hpp"
#include "cli/open_builder.hpp"
#include "embree/embree_scene.hpp"
#include "measure/rounds.hpp"

namespace clbvh::tool {
namespace {

class LayoutContestant final : public FirstRayContestant {
public:
    LayoutContestant(const std::string& id, const BenchSettings& settings, const BuildOptions& options,
                     const Mesh& mesh)
        : FirstRayContestant(id), id_(id), settings_(settings), options_(options), mesh_(mesh) {}

    void closest(std::span<const Ray> rays, std::span<Hit> hits) override { tracer().closest(rays, hits); }
    void any(std::span<const Ray> rays, std::span<std::uint8_t> is_hit) override { tracer().any(rays, is_hit); }
    void closest_singly(std::span<const Ray> rays, std::span<Hit> hits) override {
        std::transform(rays.begin(), rays.end(), hits.begin(),
                       [this](const Ray& ray) { return tracer_->closest(ray); });
    }
    void any_singly(std::span<const Ray> rays, std::span<std::uint8_t> is_hit) override {
        std::transform(rays.begin(), rays.end(), is_hit.begin(),
                       [this](const Ray& ray) -> std::uint8_t { return tracer_->any(ray) ? 1 : 0; });
    }
    [[nodiscard]] bool has_span_calls() const noexcept override { return true; }

protected:
    void build_and_trace() override {
        if (!builder_) builder_.emplace(open_builder(id_, settings_.context, options_));
        builder_->build_layout(mesh_, layout_, &stats_);
        tracer_.emplace(std::as_const(layout_), TracerOptions{.thread_count = 1});
        static_cast<void>(
            tracer_->closest(Ray{mesh_.vertices.empty() ? Vec3{} : mesh_.vertices.front(), 0.0f, {0, 0, 1}}));
    }

    void describe(FirstRayResult& result) const override {
        result.stages = stats_.stages;
        if (mesh_.triangles.empty()) return;
        const std::uint64_t bytes =
            layout_.nodes.size() * sizeof(WideNode<8>) + layout_.blocks.size() * sizeof(TriangleBlock);
        result.bytes_per_triangle = static_cast<double>(bytes) / static_cast<double>(mesh_.triangles.size());
    }

private:
    [[nodiscard]] const Tracer& tracer() const { return tracer_.value(); }

    std::string id_;
    const BenchSettings& settings_;
    const BuildOptions& options_;
    const Mesh& mesh_;
    std::optional<Builder> builder_;  // made by the first, cold run
    Wide8 layout_;
    BuildStats stats_;
    std::optional<Tracer> tracer_;
};

std::vector<Ray> rays_of(RayKind kind, const Mesh& mesh, const Camera& camera, FirstRayContestant& entrant) {
    const ClosestHits trace = [&](std::span<const Ray> rays, std::span<Hit> hits) { entrant.closest(rays, hits); };
    return make_rays(kind, mesh, trace, camera, {std::uint64_t{1} << 18, 1});
}

}  // namespace

std::vector<FirstRayResult> first_ray_scene(const BenchSettings& settings, std::string_view scene, const Mesh& mesh,
                                            const Camera& camera, ProgressBar& bar) {
    RoundsProgress progress(scene, bar);
    BuildOptions options = settings.options;
    options.progress = [](const Progress&) { return !interrupted(); };
    FirstRayEntrants entrants;
    for (const std::string& id : settings.builders)
        entrants.push_back(std::make_unique<LayoutContestant>(id, settings, options, mesh));
    if (settings.peers) {
        FirstRayEntrants peers = make_embree_scenes(settings.options, mesh);
        std::move(peers.begin(), peers.end(), std::back_inserter(entrants));
    }
    if (entrants.empty()) return {};
    std::vector<Contestant*> contestants;
    for (const auto& entrant : entrants)
        contestants.push_back(entrant.get());
    run_rounds(contestants, settings.runs, progress);

    std::vector<FirstRayResult> results;
    for (const auto& entrant : entrants) {
        FirstRayResult& result = results.emplace_back(entrant->result());
        result.scene = scene;
        result.triangles = mesh.triangles.size();
    }
    bar.show_now(1.0, "tracing");
    trace_entrants(entrants, rays_of(RayKind::primary, mesh, camera, *entrants.front()),
                   rays_of(RayKind::diffuse, mesh, camera, *entrants.front()), settings.runs, results);
    return results;
}

}  // namespace clbvh::tool
