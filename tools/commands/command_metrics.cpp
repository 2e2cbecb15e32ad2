
#include <CLI/CLI.hpp>
#include <algorithm>
#include <clbvh/core/error.hpp>
#include <cstdint>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "cli/build_arguments.hpp"
#include "cli/builder_choice.hpp"
#include "cli/interrupt.hpp"
#include "cli/json_output.hpp"
#include "cli/progress_bar.hpp"
#include "cli/scene_arguments.hpp"
#include "cli/scene_check.hpp"
#include "commands/command.hpp"
#include "rays/measuring_arguments.hpp"
#include "rays/metrics_scene.hpp"
#include "report/bench_report.hpp"
#include "report/cost_prediction.hpp"
#include "report/result_json.hpp"
#include "report/scene_report.hpp"

namespace clbvh::tool {
namespace {

struct MetricsArguments {
    std::vector<std::string> scenes;
    SceneArguments loading;
    ViewArguments view;
    std::string builders = "all";
    RayArguments rays;
    TracerArguments tracing;
    MeasuringArguments measuring;
    BuildArguments build;
    JsonOutput json;
};

/// Scene after scene; the document holds what has been done so far.
class Measuring {
public:
    explicit Measuring(const MetricsArguments& arguments)
        : arguments_(arguments), choice_(choose_builders(arguments.builders, arguments.build.device, kBuildersWayOut)) {
        choice_.context = arguments.tracing.context(std::move(choice_.context), arguments.build.device);
        settings_ = {{choice_.ids, arguments.measuring.runs, arguments.build.options, choice_.context},
                     arguments.measuring.epo_samples};
    }

    void run() {
        report_.print(unavailable_report(choice_));
        ProgressBar bar;
        for (const std::string& scene : arguments_.scenes) {
            bar.show_now(0.0, "loading " + scene);
            const ViewedScene viewed =
                load_viewed(scene, arguments_.loading, arguments_.view, arguments_.build.options.thread_count);
            throw_if_interrupted();
            std::vector<MetricsResult> of_scene =
                measure_scene(settings_, arguments_.rays, arguments_.tracing, scene, viewed, bar);
            bar.erase();
            std::vector<Prediction> predictions = predict(of_scene);
            report_.print_tables(metrics_report(of_scene) + prediction_report(predictions) + '\n');
            std::ranges::move(of_scene, std::back_inserter(results_));
            std::ranges::move(predictions, std::back_inserter(predictions_));
        }
        report_.print(pooled_report(predictions_));
    }

    [[nodiscard]] bool has_results() const { return !results_.empty(); }

    [[nodiscard]] nlohmann::ordered_json document() const {
        nlohmann::ordered_json list = nlohmann::ordered_json::array();
        for (const MetricsResult& result : results_)
            list.push_back(to_json(result));
        nlohmann::ordered_json document =
            document_json(choice_.context, arguments_.loading, arguments_.build.options, std::move(list));
        document["correlation"] = to_json(predictions_);
        report_.add_unavailable(document);
        return document;
    }

    /// Tells standard error about builders whose hits are not the first one's, and returns the exit code.
    [[nodiscard]] int finish() const {
        std::vector<TraceResult> traces;
        std::ranges::transform(results_, std::back_inserter(traces), &MetricsResult::trace);
        return report_mismatches(traces);
    }

private:
    const MetricsArguments& arguments_;
    BuilderChoice choice_;
    SceneReport report_{choice_, arguments_.loading, arguments_.json};
    MetricsSettings settings_;
    std::vector<MetricsResult> results_;
    std::vector<Prediction> predictions_;
};

/// What can be seen before any work.
void check_arguments(const MetricsArguments& arguments) {
    arguments.build.check();
    arguments.view.check();
    arguments.json.require_writable();
    arguments.rays.check(arguments.scenes.size());
    require_one_kind(arguments.rays, "metrics are");
    std::ranges::for_each(arguments.scenes, require_scene);
}

int run_metrics(const MetricsArguments& arguments) {
    check_arguments(arguments);
    Measuring measuring(arguments);
    run_and_write(
        arguments.json, [&] { measuring.run(); }, [&] { return measuring.has_results(); },
        [&] { return measuring.document(); });
    return measuring.finish();
}

void add_measuring_options(CLI::App& command, MetricsArguments& arguments) {
    command
        .add_option("--builders,--builder", arguments.builders,
                    "Ids or groups (all, host, device, presets) with commas between them; see clbvh builders")
        ->type_name("A,B,C")
        ->capture_default_str();
    arguments.measuring.add_options(command);
}

}  // namespace

Command add_metrics_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand("metrics", "Describe trees, and say how well SAH, EPO and LCV predict rays");
    command->footer(
        "EPO, LCV and the weights alpha and beta are those of Aila, Karras and Laine 2013; docs/metrics.md defines "
        "them.\nns/ray is of eight children at a time, binary of the tree's own nodes. All trees stay in "
        "memory.");
    auto arguments = std::make_shared<MetricsArguments>();
    command->add_option("scene", arguments->scenes, kScenesHelp)->type_name("SCENE")->required();
    add_measuring_options(*command, *arguments);
    arguments->rays.add_options(*command);
    arguments->tracing.add_options(*command);
    arguments->view.add_options(*command);
    arguments->loading.add_options(*command);
    arguments->build.add_options(*command);
    arguments->json.add_option(*command);
    return {command, [arguments] { return run_metrics(*arguments); }};
}

}  // namespace clbvh::tool
