#include "measure/first_ray.hpp"

#include <algorithm>
#include <array>

#include "cli/interrupt.hpp"
#include "cli/stopwatch.hpp"

namespace clbvh::tool {
namespace {

/// One way in which rays are asked, and where the time goes.
struct Question {
    std::span<const Ray> rays;
    bool any, singly;
    std::optional<double> FirstRayResult::*nanoseconds;
};

double milliseconds(FirstRayContestant& entrant, const Question& question, std::vector<Hit>& hits,
                    std::vector<std::uint8_t>& is_hit) {
    const Stopwatch stopwatch;
    const std::span<Hit> closest = std::span(hits).first(question.rays.size());
    const std::span<std::uint8_t> any = std::span(is_hit).first(question.rays.size());
    if (question.any) {
        question.singly ? entrant.any_singly(question.rays, any) : entrant.any(question.rays, any);
    } else {
        question.singly ? entrant.closest_singly(question.rays, closest) : entrant.closest(question.rays, closest);
    }
    return stopwatch.milliseconds();
}

std::array<Question, 6> questions(std::span<const Ray> primary, std::span<const Ray> diffuse) {
    using Result = FirstRayResult;
    return {{{primary, false, false, &Result::primary_ns},
             {primary, false, true, &Result::primary_single_ns},
             {diffuse, false, false, &Result::closest_ns},
             {diffuse, false, true, &Result::closest_single_ns},
             {diffuse, true, false, &Result::any_ns},
             {diffuse, true, true, &Result::any_single_ns}}};
}

}  // namespace

void FirstRayContestant::run(bool counted) {
    const Stopwatch stopwatch;
    build_and_trace();
    const double time = stopwatch.milliseconds();
    if (!cold_ms_) cold_ms_ = time;
    if (counted) times_.push_back(time);
}

FirstRayResult FirstRayContestant::result() const {
    FirstRayResult result;
    result.builder = name_;
    result.cold_ms = cold_ms_.value_or(0.0);
    result.first_ray_ms = summarize(times_);
    describe(result);
    return result;
}

void trace_entrants(const FirstRayEntrants& entrants, std::span<const Ray> primary, std::span<const Ray> diffuse,
                    std::size_t runs, std::span<FirstRayResult> results) {
    std::vector<Hit> hits(std::max(primary.size(), diffuse.size()));
    std::vector<std::uint8_t> is_hit(hits.size());
    for (const Question& question : questions(primary, diffuse)) {
        if (question.rays.empty()) continue;
        std::vector<std::vector<double>> times(entrants.size());
        for (std::size_t round = 0; round <= runs; ++round) {
            for (std::size_t k = 0; k < entrants.size(); ++k) {
                throw_if_interrupted();
                const std::size_t i = (round + k) % entrants.size();
                if (question.singly && !entrants[i]->has_span_calls()) continue;
                const double time = milliseconds(*entrants[i], question, hits, is_hit);
                if (round > 0) times[i].push_back(time);
            }
        }
        for (std::size_t i = 0; i < entrants.size(); ++i) {
            if (times[i].empty()) continue;
            results[i].*question.nanoseconds =
                summarize(times[i]).median * 1e6 / static_cast<double>(question.rays.size());
        }
    }
}

}  // namespace clbvh::tool
