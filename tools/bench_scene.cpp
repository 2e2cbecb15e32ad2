#include "bench_scene.hpp"

#include <fmt/format.h>

#include <clbvh/builder.hpp>
#include <cstddef>
#include <iterator>
#include <memory>
#include <span>

#include "builder_contestant.hpp"
#include "embree_peer.hpp"
#include "interrupt.hpp"
#include "open_builder.hpp"
#include "sort_contestant.hpp"

namespace clbvh::tool {
namespace {

using Entrants = std::vector<std::unique_ptr<TreeContestant>>;

/// How far all rounds together are, shown in a bar.
class RoundsProgress {
public:
    RoundsProgress(std::string_view scene, ProgressBar& bar) : scene_(scene), bar_(bar) {}

    /// One contestant's turn begins; `begin` to `end` is its part of all the rounds.
    void begin_turn(double begin, double end, std::size_t round, std::string_view name) {
        begin_ = begin;
        end_ = end;
        const std::string what = round == 0 ? "warm-up" : fmt::format("run {}", round);
        label_ = fmt::format("{}, {}, {}", scene_, what, name);
        bar_.show_now(begin, label_);
    }
    /// `part` of the turn is done.
    void show(double part) { bar_.show(begin_ + part * (end_ - begin_), label_); }

private:
    std::string_view scene_;
    ProgressBar& bar_;
    double begin_ = 0.0;
    double end_ = 0.0;
    std::string label_;
};

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

void run_rounds(std::span<Contestant* const> contestants, std::size_t runs, RoundsProgress& progress) {
    const std::size_t count = contestants.size();
    const auto part = [turns = static_cast<double>((runs + 1) * count)](std::size_t turn) {
        return static_cast<double>(turn) / turns;
    };
    for (std::size_t round = 0; round <= runs; ++round) {
        for (std::size_t turn = 0; turn < count; ++turn) {
            Contestant& contestant = *contestants[(turn + round) % count];
            const std::size_t done = round * count + turn;
            progress.begin_turn(part(done), part(done + 1), round, contestant.name());
            throw_if_interrupted();
            contestant.run(round > 0);
        }
    }
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
    run_rounds(contestants, settings.runs, progress);

    std::vector<BuildResult> results;
    for (const auto& entrant : entrants) {
        throw_if_interrupted();
        BuildResult result = entrant->result();
        result.scene = scene;
        result.native_sort_ms = sort.milliseconds();
        describe_tree(result, entrant->tree(), mesh, settings.validated);
        results.push_back(std::move(result));
    }
    return results;
}

}  // namespace clbvh::tool
