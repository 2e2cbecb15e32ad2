#include "sweep/tuning.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <clbvh/builder.hpp>
#include <clbvh/core/error.hpp>
#include <cstddef>
#include <memory>
#include <utility>

#include "cli/interrupt.hpp"
#include "measure/contestant.hpp"
#include "measure/rounds.hpp"
#include "report/table.hpp"

namespace clbvh::tool {
namespace {

/// The least part of the time that another value must save, in the median and in the best run: less is noise.
constexpr double kLeastGain = 0.03;

/// One value of a knob on one mesh.
class TrialContestant final : public Contestant {
public:
    TrialContestant(std::string name, Builder builder, const Mesh& mesh)
        : name_(std::move(name)), builder_(std::move(builder)) {
        builder_.upload(mesh);
    }

    [[nodiscard]] std::string_view name() const override { return name_; }
    void run(bool counted) override {
        const double milliseconds = builder_.run().build_ms;
        if (counted) build_ms_.push_back(milliseconds);
    }
    [[nodiscard]] Sample build_ms() const { return summarize(build_ms_); }

private:
    std::string name_;
    Builder builder_;
    std::vector<double> build_ms_;
};

/// A builder with one value of the knob; none where the device cannot serve it.
std::optional<Builder> builder_with(const Knob& knob, std::uint32_t value, const Context& context, BuildOptions options,
                                    RoundsProgress& progress) {
    options.progress = [&progress](const Progress& build) {
        progress.show(build.fraction);
        return !interrupted();
    };
    knob.set(options, value);
    try {
        return Builder(knob.builder, context, options);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::unsupported && error.code() != ErrorCode::invalid_input) throw;
        return std::nullopt;
    }
}

/// Adds what each value costs on this mesh to its trial; values that cannot run lose theirs.
void try_on(const Mesh& mesh, const std::string& title, TunedKnob& tuned, std::size_t runs, const Context& context,
            const BuildOptions& options, ProgressBar& bar) {
    RoundsProgress progress(title, bar);
    std::vector<std::unique_ptr<TrialContestant>> entrants;
    std::vector<Trial> trials;
    for (Trial& trial : tuned.trials) {
        throw_if_interrupted();
        const std::string name = fmt::format("{} {}", tuned.knob.option, value_text(tuned.knob, trial.value));
        bar.show_now(0.0, fmt::format("{}, compiling for {}", title, name));
        std::optional<Builder> builder = builder_with(tuned.knob, trial.value, context, options, progress);
        if (!builder) continue;
        entrants.push_back(std::make_unique<TrialContestant>(name, *std::move(builder), mesh));
        trials.push_back(std::move(trial));
    }
    std::vector<Contestant*> contestants;
    std::ranges::transform(entrants, std::back_inserter(contestants),
                           [](const auto& entrant) { return entrant.get(); });
    run_rounds(contestants, runs, progress);
    for (std::size_t i = 0; i < trials.size(); ++i)
        trials[i].build_ms.push_back(entrants[i]->build_ms());
    tuned.trials = std::move(trials);
}

/// Geometric mean over the scenes of one field, relative to another trial.
double relative_to(const Trial& other, const Trial& trial, double Sample::*field) {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < trial.build_ms.size(); ++i)
        ratios.push_back(trial.build_ms[i].*field / other.build_ms[i].*field);
    return geometric_mean(ratios);
}

void choose(std::vector<Trial>& trials) {
    Trial& automatic = trials.front();
    Trial* best = &automatic;
    for (Trial& trial : trials) {
        trial.relative = relative_to(automatic, trial, &Sample::median);
        const double least = std::max(trial.relative, relative_to(automatic, trial, &Sample::min));
        if (least < 1.0 - kLeastGain && trial.relative < best->relative) best = &trial;
    }
    best->chosen = true;
}

void set_sort_shape(BuildOptions& options, std::uint32_t value) {
    options.device.sort_shape = static_cast<Shape>(value);
}

}  // namespace

std::vector<Knob> knobs_of(const Context& context) {
    std::vector<Knob> knobs;
    constexpr auto kGroup = static_cast<std::uint32_t>(Shape::group);
    constexpr auto kLane = static_cast<std::uint32_t>(Shape::lane);
    const Knob chunk{"chunk_size",
                     "plocpp",
                     {0, 128, 256, 512, 1024, 2048},
                     [](BuildOptions& options, std::uint32_t value) { options.ploc.chunk_size = value; },
                     [](Profile& profile, std::uint32_t value) { profile.chunk_size = value; }};
    const Knob work_group{"work_group_size",
                          "plocpp",
                          {0, 64, 128, 256, 512, 1024},
                          [](BuildOptions& options, std::uint32_t value) { options.ploc.work_group_size = value; },
                          [](Profile& profile, std::uint32_t value) { profile.work_group_size = value; }};
    if (context.prefers_lane_shape()) {
        knobs.push_back(
            {"sort_shape", "lbvh", {0, kGroup, kLane}, set_sort_shape, [](Profile& profile, std::uint32_t value) {
                 profile.sort_shape = static_cast<Shape>(value);
             }});
    }
    knobs.push_back(context.prefers_lane_shape() ? chunk : work_group);
    knobs.push_back({"single_group_threshold",
                     "plocpp",
                     {0, 1024, 2048, 4096, 8192, 16384, 32768},
                     [](BuildOptions& options, std::uint32_t value) { options.ploc.single_group_threshold = value; },
                     [](Profile& profile, std::uint32_t value) { profile.single_group_threshold = value; }});
    return knobs;
}

std::string value_text(const Knob& knob, std::uint32_t value) {
    if (value == 0) return "auto";
    return knob.option == "sort_shape" ? std::string(to_string(static_cast<Shape>(value))) : std::to_string(value);
}

TunedKnob tune_knob(const Knob& knob, const TuneSettings& settings, const Context& context, const BuildOptions& options,
                    ProgressBar& bar) {
    TunedKnob tuned{knob, {}};
    for (const std::uint32_t value : knob.values)
        tuned.trials.push_back({value, {}});
    for (const std::string& scene : settings.scenes) {
        throw_if_interrupted();
        bar.show_now(0.0, "loading " + scene);
        try_on(settings.loading.load(scene), scene, tuned, settings.runs, context, options, bar);
    }
    bar.erase();
    choose(tuned.trials);
    return tuned;
}

std::uint32_t chosen_value(const TunedKnob& tuned) {
    return std::ranges::find(tuned.trials, true, &Trial::chosen)->value;
}

std::string hand_over_report(HandOver hand_over) {
    return hand_over == HandOver::within_launch ? "self-test: work groups hand over to each other within a launch"
                                                : "self-test: what work groups hand over within a launch gets lost";
}

std::string tuning_report(const TunedKnob& tuned, const TuneSettings& settings) {
    std::vector<std::string> header{std::string(tuned.knob.option)};
    for (const std::string& scene : settings.scenes)
        header.push_back(scene + " ms");
    header.insert(header.end(), {"to auto", "chosen"});
    Table table(std::move(header));
    for (const Trial& trial : tuned.trials) {
        std::vector<std::string> row{value_text(tuned.knob, trial.value)};
        for (const Sample& sample : trial.build_ms)
            row.push_back(fixed_text(sample.median, 2));
        row.push_back(fixed_text(trial.relative, 3));
        row.emplace_back(trial.chosen ? "yes" : "");
        table.add_row(std::move(row));
    }
    return fmt::format("{}, with {}\n{}\n", tuned.knob.option, tuned.knob.builder, table.text());
}

}  // namespace clbvh::tool
