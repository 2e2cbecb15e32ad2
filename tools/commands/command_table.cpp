
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

#include "aila2013/aila_builders.hpp"
#include "aila2013/aila_report.hpp"
#include "aila2013/aila_scene.hpp"
#include "cli/build_arguments.hpp"
#include "cli/builder_choice.hpp"
#include "cli/interrupt.hpp"
#include "cli/json_output.hpp"
#include "cli/progress_bar.hpp"
#include "cli/scene_arguments.hpp"
#include "cli/scene_check.hpp"
#include "commands/command.hpp"
#include "rays/measuring_arguments.hpp"
#include "report/cost_prediction.hpp"
#include "report/result_json.hpp"
#include "report/scene_report.hpp"

namespace clbvh::tool {
namespace {

struct TableArguments {
    std::vector<std::string> scenes;
    SceneArguments loading;
    ViewArguments view;
    std::string builders = "all";
    RayArguments rays;
    TracerArguments tracing;  // of which only the triangle test is asked for
    MeasuringArguments measuring;
    AnnealConfig annealing;
    BuildArguments build;
    JsonOutput json;
};

constexpr std::uint32_t kPaperLeaf = 8;
constexpr const char* kWayOut = "--builders bbvh,sbvh,agglo needs no device";

/// The device that builders need; where none does, one to trace on if there is any.
BuilderChoice open_device(const std::vector<AilaBuilder>& builders, const std::string& device) {
    std::string ids;
    for (const AilaBuilder& each : builders)
        ids += (ids.empty() ? "" : ",") + std::string(each.builder);
    BuilderChoice choice = choose_builders(ids, device, kWayOut);
    if (choice.context) return choice;
    try {
        choice.context = Context::open(device);
    } catch (const Error& error) {
        if (!device.empty()) throw;
        choice.reason = error.what();
    }
    return choice;
}

/// Scene after scene; the document holds what has been done so far.
class Comparing {
public:
    explicit Comparing(const TableArguments& arguments) : arguments_(arguments) {
        settings_.builders = choose_aila_builders(arguments.builders);
        choice_ = open_device(settings_.builders, arguments.build.device);
        settings_.trees = {arguments.build.options, arguments.annealing, choice_.context};
        settings_.runs = arguments.measuring.runs;
        settings_.epo_samples = arguments.measuring.epo_samples;
        settings_.triangle_test = arguments.tracing.triangle_test;
        settings_.traces_on_device = choice_.context.has_value();
    }

    void run() {
        if (!settings_.traces_on_device) report_.print("rays are traced on the host only: " + choice_.reason + '\n');
        ProgressBar bar;
        for (const std::string& scene : arguments_.scenes) {
            bar.show_now(0.0, "loading " + scene);
            const ViewedScene viewed =
                load_viewed(scene, arguments_.loading, arguments_.view, arguments_.build.options.thread_count);
            throw_if_interrupted();
            scenes_.push_back(measure_aila_scene(settings_, arguments_.rays, scene, viewed, bar));
            bar.erase();
            const std::vector<Prediction> predictions = predict(scenes_.back());
            report_.print_tables(aila_report(scenes_.back(), predictions) + '\n');
            std::ranges::copy(predictions, std::back_inserter(predictions_));
        }
        report_.print(pooled_report(predictions_));
    }

    [[nodiscard]] bool has_results() const { return !scenes_.empty(); }

    [[nodiscard]] nlohmann::ordered_json document() const {
        nlohmann::ordered_json list = nlohmann::ordered_json::array();
        for (const AilaScene& scene : scenes_) {
            for (nlohmann::ordered_json& result : to_json(scene))
                list.push_back(std::move(result));
        }
        nlohmann::ordered_json document =
            document_json(choice_.context, arguments_.loading, arguments_.build.options, std::move(list));
        document["anneal_passes"] = arguments_.annealing.length;
        document["correlation"] = to_json(predictions_);
        if (!settings_.traces_on_device) document["no_device"] = choice_.reason;
        return document;
    }

    /// Tells standard error about builders whose hits are not the first one's, and returns the exit code.
    [[nodiscard]] int finish() const {
        std::vector<TraceResult> traces;
        for (const AilaScene& scene : scenes_) {
            std::ranges::transform(scene.host, std::back_inserter(traces), &MetricsResult::trace);
            std::ranges::transform(scene.device, std::back_inserter(traces), &MetricsResult::trace);
        }
        return report_mismatches(traces);
    }

private:
    const TableArguments& arguments_;
    BuilderChoice choice_;
    SceneReport report_{choice_, arguments_.loading, arguments_.json};
    AilaSettings settings_;
    std::vector<AilaScene> scenes_;
    std::vector<Prediction> predictions_;
};

/// Two ways to split triangles do not go together.
void check_splitting(const TableArguments& arguments) {
    if (arguments.build.options.presplit_level == 0) return;
    for (const AilaBuilder& builder : choose_aila_builders(arguments.builders)) {
        if (builder.id == "streelet")
            throw Error(ErrorCode::invalid_input,
                        "--presplit: STreelet splits triangles by a quota of its own; leave one of them out");
    }
}

/// What can be seen before any work.
void check_arguments(const TableArguments& arguments) {
    arguments.build.check();
    check_splitting(arguments);
    arguments.view.check();
    arguments.json.require_writable();
    arguments.rays.check(arguments.scenes.size());
    require_one_kind(arguments.rays, "the table is");
    std::ranges::for_each(arguments.scenes, require_scene);
}

int run_table(const TableArguments& arguments) {
    check_arguments(arguments);
    Comparing comparing(arguments);
    run_and_write(
        arguments.json, [&] { comparing.run(); }, [&] { return comparing.has_results(); },
        [&] { return comparing.document(); });
    return comparing.finish();
}

void add_measuring_options(CLI::App& command, TableArguments& arguments) {
    command
        .add_option("--builders,--builder", arguments.builders,
                    "all, or some of lbvh, bbvh, sbvh, agglo, bittner, hclimb, anneal, treelet and streelet, with "
                    "commas between them")
        ->type_name("A,B,C")
        ->capture_default_str();
    arguments.measuring.add_options(command);
    command
        .add_option("--anneal-passes", arguments.annealing.length,
                    "Passes of annealing, 1 to 1000000: the paper's 1250 take minutes over millions of triangles")
        ->check(CLI::Range(1, 1000000))
        ->type_name("N")
        ->capture_default_str();
}

}  // namespace

Command add_table_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand("table", "Compare the nine builders of Aila, Karras and Laine 2013");
    command->footer(
        "Lays their table 1 out for any mesh: what rays cost, SAH, EPO and LCV, and how well these predict that; "
        "docs/table.md\nsays which builder is which. --max-leaf holds for all but LBVH, whose leaves are triangles. "
        "All trees stay in memory.");
    auto arguments = std::make_shared<TableArguments>();
    arguments->build.options.max_leaf_size = kPaperLeaf;
    command->add_option("scene", arguments->scenes, kScenesHelp)->type_name("SCENE")->required();
    add_measuring_options(*command, *arguments);
    arguments->rays.add_options(*command);
    arguments->tracing.add_triangle_test(*command);
    arguments->view.add_options(*command);
    arguments->loading.add_options(*command);
    arguments->build.add_options(*command);
    for (const char* option : {"--optimize", "--optimize-passes", "--optimize-on"})
        command->remove_option(command->get_option(option));  // each of the nine has its own
    arguments->json.add_option(*command);
    return {command, [arguments] { return run_table(*arguments); }};
}

}  // namespace clbvh::tool
