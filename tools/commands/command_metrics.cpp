#include <CLI/CLI.hpp>
#include <algorithm>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "commands/command.hpp"
#include "commands/scene_command.hpp"
#include "rays/measuring_arguments.hpp"
#include "rays/metrics_scene.hpp"
#include "report/cost_prediction.hpp"

namespace clbvh::tool {
namespace {

struct MetricsArguments : RayCommandArguments {
    MeasuringArguments measuring;
};

BuilderChoice choose_for_metrics(const MetricsArguments& arguments) {
    BuilderChoice choice = choose_builders(arguments.builders, arguments.build.device, kBuildersWayOut);
    arguments.build.note_unread(choice.ids);
    choice.context = arguments.tracing.context(std::move(choice.context), arguments.build.device);
    return choice;
}

class Measuring final : public RaySceneCommand {
public:
    explicit Measuring(const MetricsArguments& arguments)
        : RaySceneCommand(arguments, choose_for_metrics(arguments)),
          arguments_(arguments),
          settings_{{choice().ids, arguments.measuring.runs, arguments.build.options, choice().context},
                    arguments.measuring.epo_samples} {}

private:
    std::string run_viewed(const std::string& scene, const ViewedScene& viewed, ProgressBar& bar) override {
        std::vector<MetricsResult> of_scene =
            measure_scene(settings_, arguments_.rays, arguments_.tracing, scene, viewed, bar);
        std::vector<Prediction> predictions = predict(of_scene);
        std::string tables = metrics_report(of_scene) + prediction_report(predictions);
        std::ranges::move(of_scene, std::back_inserter(results_));
        std::ranges::move(predictions, std::back_inserter(predictions_));
        return tables;
    }

    [[nodiscard]] std::string closing() const override { return pooled_report(predictions_); }

    [[nodiscard]] nlohmann::ordered_json results() const override {
        nlohmann::ordered_json list = nlohmann::ordered_json::array();
        for (const MetricsResult& result : results_)
            list.push_back(to_json(result));
        return list;
    }

    void add_fields(nlohmann::ordered_json& document) const override {
        document["correlation"] = to_json(predictions_);
    }

    [[nodiscard]] int report_faults() const override {
        std::vector<TraceResult> traces;
        std::ranges::transform(results_, std::back_inserter(traces), &MetricsResult::trace);
        return report_mismatches(traces);
    }

    const MetricsArguments& arguments_;
    MetricsSettings settings_;
    std::vector<MetricsResult> results_;
    std::vector<Prediction> predictions_;
};

int run_metrics(const MetricsArguments& arguments) {
    require_one_kind(arguments.rays, "metrics are");
    arguments.check();
    return Measuring(arguments).run();
}

}  // namespace

Command add_metrics_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand("metrics", "Describe trees, and say how well SAH, EPO and LCV predict rays");
    command->footer(
        "EPO, LCV and the weights alpha and beta are those of Aila, Karras and Laine 2013; docs/metrics.md defines "
        "them.\nns/ray is of eight children at a time, binary of the tree's own nodes. All trees stay in "
        "memory.");
    auto arguments = std::make_shared<MetricsArguments>();
    arguments->add_scenes_and_builders(*command, kBuildersHelp);
    arguments->measuring.add_options(*command);
    arguments->rays.add_options(*command);
    arguments->tracing.add_options(*command);
    arguments->add_viewing_and_building(*command);
    return {command, [arguments] { return run_metrics(*arguments); }};
}

}  // namespace clbvh::tool
