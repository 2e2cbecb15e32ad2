#include "measure/ray_cost.hpp"

#include <algorithm>
#include <clbvh/metrics/lcv.hpp>
#include <memory>
#include <utility>

#include "cli/interrupt.hpp"
#include "cli/stopwatch.hpp"
#include "measure/contestant.hpp"
#include "measure/rounds.hpp"

namespace clbvh::tool {
namespace {

/// Queries of a set, and the answers: a hit each or, where any hit will do, whether there is one.
class Answers {
public:
    explicit Answers(const RaySet& set) : set_(set) {
        if (asks_for_any_hit(set.kind)) {
            is_hit_.resize(set.rays.size());
        } else {
            hits_.resize(set.rays.size());
        }
    }

    /// In pieces, between which Ctrl-C is heeded: bad trees take minutes. Throws Error(cancelled).
    void ask(RayEngine& engine, std::span<RayCounts> counts) {
        const std::span<const Ray> rays = set_.rays;
        const std::size_t piece = engine.rays_at_once();
        for (std::size_t begin = 0; begin < rays.size(); begin += piece) {
            throw_if_interrupted();
            const std::size_t size = std::min(piece, rays.size() - begin);
            const std::span<RayCounts> counts_of_piece = counts.empty() ? counts : counts.subspan(begin, size);
            if (asks_for_any_hit(set_.kind)) {
                engine.any(rays.subspan(begin, size), std::span(is_hit_).subspan(begin, size), counts_of_piece);
            } else {
                engine.closest(rays.subspan(begin, size), std::span(hits_).subspan(begin, size), counts_of_piece);
            }
        }
    }
    [[nodiscard]] std::uint64_t hits() const {
        const auto found = std::ranges::count_if(hits_, [](const Hit& hit) { return bool(hit); });
        return static_cast<std::uint64_t>(found + std::ranges::count(is_hit_, std::uint8_t{1}));
    }
    [[nodiscard]] std::uint64_t differences(const Answers& other) const {
        std::uint64_t count = 0;
        for (std::size_t i = 0; i < hits_.size(); ++i)
            count += hits_[i] == other.hits_[i] ? 0U : 1U;
        for (std::size_t i = 0; i < is_hit_.size(); ++i)
            count += is_hit_[i] == other.is_hit_[i] ? 0U : 1U;
        return count;
    }

private:
    const RaySet& set_;
    std::vector<Hit> hits_;
    std::vector<std::uint8_t> is_hit_;
};

class TraceContestant final : public Contestant {
public:
    TraceContestant(const RayEntrant& entrant, Answers& answers, const Answers& expected)
        : entrant_(entrant), answers_(answers), expected_(expected) {}

    [[nodiscard]] std::string_view name() const override { return entrant_.name; }
    void run(bool counted) override {
        const Stopwatch stopwatch;
        answers_.ask(*entrant_.engine, {});
        if (counted) {
            milliseconds_.push_back(stopwatch.milliseconds());
        } else {
            mismatches_ = answers_.differences(expected_);
        }
    }
    [[nodiscard]] Sample milliseconds() const { return summarize(milliseconds_); }
    /// In the round that warms up: what is not counted may go another way than what is.
    [[nodiscard]] std::uint64_t mismatches() const { return mismatches_; }

private:
    const RayEntrant& entrant_;
    Answers& answers_;
    const Answers& expected_;
    std::uint64_t mismatches_ = 0;
    std::vector<double> milliseconds_;
};

void set_counts(RayCost& cost, std::span<const RayCounts> counts) {
    const MeanCounts means = mean_counts(counts);
    cost.inner_per_ray = means.inner_nodes;
    cost.leaves_per_ray = means.leaves;
    cost.triangles_per_ray = means.triangles;
    cost.leaf_count_variability = leaf_count_variability(counts);
}

}  // namespace

double RayCost::ns_per_ray() const {
    return ray_count > 0 ? trace_ms.median * 1e6 / static_cast<double>(ray_count) : 0.0;
}

double RayCost::mrays_per_s() const {
    return trace_ms.median > 0.0 ? static_cast<double>(ray_count) / trace_ms.median / 1e3 : 0.0;
}

std::vector<RayCost> measure_rays(std::span<const RayEntrant> entrants, RayEngine& reference, const RaySet& set,
                                  std::size_t runs, RoundsProgress& progress) {
    std::vector<RayCost> costs(entrants.size());
    std::vector<RayCounts> counts(set.rays.size());
    Answers expected(set);
    expected.ask(reference, {});
    Answers answers(set);
    std::vector<std::unique_ptr<TraceContestant>> contestants;
    std::vector<Contestant*> turns;
    for (std::size_t i = 0; i < entrants.size(); ++i) {
        throw_if_interrupted();
        answers.ask(*entrants[i].engine, counts);
        set_counts(costs[i], counts);
        costs[i].ray_count = set.rays.size();
        costs[i].hits = answers.hits();
        costs[i].mismatches = answers.differences(expected);
        contestants.push_back(std::make_unique<TraceContestant>(entrants[i], answers, expected));
        turns.push_back(contestants.back().get());
    }
    run_rounds(turns, runs, progress);
    for (std::size_t i = 0; i < entrants.size(); ++i) {
        costs[i].trace_ms = contestants[i]->milliseconds();
        costs[i].mismatches += contestants[i]->mismatches();
    }
    return costs;
}

}  // namespace clbvh::tool
