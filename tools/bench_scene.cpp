#include "bench_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <clbvh/builder.hpp>
#include <cstddef>
#include <functional>
#include <numeric>
#include <random>

#include "interrupt.hpp"
#include "native_sort.hpp"
#include "stopwatch.hpp"

namespace clbvh::tool {
namespace {

struct Entrant {
    Builder builder;
    std::vector<BuildStats> runs;
};

/// The native sort as a contestant: always the same random keys.
class SortEntrant {
public:
    explicit SortEntrant(std::size_t count) : sort_(count), random_keys_(count), keys_(count), values_(count) {
        std::mt19937_64 random;
        std::generate(random_keys_.begin(), random_keys_.end(), std::ref(random));
    }

    double run_ms() {
        std::copy(random_keys_.begin(), random_keys_.end(), keys_.begin());
        std::iota(values_.begin(), values_.end(), 0u);
        const Stopwatch stopwatch;
        sort_.sort(keys_, values_);
        return stopwatch.milliseconds();
    }

private:
    NativeSort sort_;
    std::vector<std::uint64_t> random_keys_;
    std::vector<std::uint64_t> keys_;
    std::vector<std::uint32_t> values_;
};

std::vector<Entrant> upload_to_all(const BenchSettings& settings, const Context& context, const Mesh& mesh) {
    BuildOptions options = settings.options;
    options.progress = [](const Progress&) { return !interrupted(); };
    std::vector<Entrant> entrants;
    for (const std::string& id : settings.builders) {
        entrants.push_back({Builder(id, context, options), {}});
        entrants.back().builder.upload(mesh);
    }
    return entrants;
}

/// Runs all rounds, and returns the times of the native sort.
Sample run_rounds(std::vector<Entrant>& entrants, SortEntrant& sort, std::size_t runs, std::string_view scene,
                  ProgressBar& bar) {
    const std::size_t contestants = entrants.size() + 1;
    std::vector<double> sort_ms;
    for (std::size_t round = 0; round <= runs; ++round) {
        for (std::size_t turn = 0; turn < contestants; ++turn) {
            const std::size_t done = round * contestants + turn;
            bar.show(static_cast<double>(done) / static_cast<double>((runs + 1) * contestants),
                     round == 0 ? fmt::format("{}, warm-up", scene) : fmt::format("{}, run {}", scene, round));
            throw_if_interrupted();
            const std::size_t who = (turn + round) % contestants;
            if (who < entrants.size()) {
                const BuildStats stats = entrants[who].builder.run();
                if (round > 0) entrants[who].runs.push_back(stats);
            } else {
                const double ms = sort.run_ms();
                if (round > 0) sort_ms.push_back(ms);
            }
        }
    }
    return summarize(std::move(sort_ms));
}

}  // namespace

std::vector<BuildResult> bench_scene(const BenchSettings& settings, const Context& context, std::string_view scene,
                                     const Mesh& mesh, ProgressBar& bar) {
    std::vector<Entrant> entrants = upload_to_all(settings, context, mesh);
    SortEntrant sort(mesh.triangles.size());
    const Sample sort_ms = run_rounds(entrants, sort, settings.runs, scene, bar);
    std::vector<BuildResult> results;
    for (const Entrant& entrant : entrants) {
        throw_if_interrupted();
        BuildResult result = summarize_runs(entrant.builder, scene, mesh, entrant.runs);
        result.native_sort_ms = sort_ms;
        describe_tree(result, entrant.builder.download(), mesh, settings.validated);
        results.push_back(std::move(result));
    }
    return results;
}

}  // namespace clbvh::tool
