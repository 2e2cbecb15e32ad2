#include "bench/bench_scene.hpp"

#include <clbvh/builder.hpp>
#include <iterator>
#include <memory>
#include <optional>
#include <span>

#include "bench/bench_rays.hpp"
#include "cli/interrupt.hpp"
#include "cli/open_builder.hpp"
#include "embree/embree_peer.hpp"
#include "measure/builder_contestant.hpp"
#include "measure/copy_contestant.hpp"
#include "measure/rounds.hpp"
#include "measure/sort_contestant.hpp"

namespace clbvh::tool {
namespace {

using Entrants = std::vector<std::unique_ptr<TreeContestant>>;

Entrants make_entrants(const BenchSettings& settings, const Mesh& mesh, RoundsProgress& progress) {
    BuildOptions options = settings.options;
    options.progress = [&progress](const Progress& build) {
        progress.show(build.fraction);
        return !interrupted();
    };
    Entrants entrants;
    for (const std::string& id : settings.builders) {
        throw_if_interrupted();
        entrants.push_back(std::make_unique<BuilderContestant>(open_builder(id, settings.context, options), mesh));
    }
    if (settings.peers) {
        Entrants peers = make_embree_peers(settings.options, mesh);
        std::move(peers.begin(), peers.end(), std::back_inserter(entrants));
    }
    return entrants;
}

/// The result of one builder, with its last tree described.
BuildResult describe(const TreeContestant& entrant, const Mesh& mesh, bool validated) {
    BuildResult result = entrant.result();
    result.triangles = mesh.triangles.size();
    if (const std::optional<Bvh> tree = entrant.tree()) describe_tree(result, *tree, mesh, validated);
    return result;
}

}  // namespace

std::vector<BuildResult> bench_scene(const BenchSettings& settings, std::string_view scene, const Mesh& mesh,
                                     ProgressBar& bar) {
    RoundsProgress progress(scene, bar);
    const Entrants entrants = make_entrants(settings, mesh, progress);
    SortContestant sort(mesh.triangles.size());
    std::vector<Contestant*> contestants;
    for (const auto& entrant : entrants)
        contestants.push_back(entrant.get());
    contestants.push_back(&sort);
    std::optional<CopyContestant> copy;
    if (settings.context) contestants.push_back(&copy.emplace(*settings.context));
    run_rounds(contestants, settings.runs, progress);

    std::vector<BuildResult> results;
    for (const auto& entrant : entrants) {
        throw_if_interrupted();
        BuildResult result = describe(*entrant, mesh, settings.validated);
        result.scene = scene;
        result.native_sort_ms = sort.milliseconds();
        if (copy && result.kind == BuilderKind::device) result.copy_gb_per_s = copy->gb_per_s();
        results.push_back(std::move(result));
    }
    if (settings.camera) {
        bench_rays(results, entrants, mesh, *settings.camera, settings.runs, settings.options.thread_count, progress);
    }
    return results;
}

}  // namespace clbvh::tool
