
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/build_arguments.hpp"
#include "cli/builder_choice.hpp"
#include "cli/interrupt.hpp"
#include "cli/json_output.hpp"
#include "cli/progress_bar.hpp"
#include "cli/scene_arguments.hpp"
#include "cli/scene_check.hpp"
#include "commands/command.hpp"
#include "rays/ray_arguments.hpp"
#include "rays/trace_scene.hpp"
#include "rays/tracer_arguments.hpp"
#include "rays/view_arguments.hpp"
#include "report/bench_report.hpp"
#include "report/result_json.hpp"
#include "report/scene_report.hpp"
#include "report/trace_result.hpp"

namespace clbvh::tool {
namespace {

struct TraceArguments {
    std::vector<std::string> scenes;
    SceneArguments loading;
    ViewArguments view;
    std::string builders = "all";
    RayArguments rays;
    TracerArguments tracing;
    std::uint32_t runs = 5;
    BuildArguments build;
    JsonOutput json;
};

/// Scene after scene; the document holds what has been done so far.
class Tracing {
public:
    explicit Tracing(const TraceArguments& arguments)
        : arguments_(arguments), choice_(choose_builders(arguments.builders, arguments.build.device, kBuildersWayOut)) {
        choice_.context = arguments.tracing.context(std::move(choice_.context), arguments.build.device);
        if (std::ranges::find(choice_.ids, kTraceBaseline) == choice_.ids.end())
            choice_.ids.emplace_back(kTraceBaseline);
        settings_ = {choice_.ids, arguments.runs, arguments.build.options, choice_.context};
    }

    void run() {
        report_.print(unavailable_report(choice_));
        ProgressBar bar;
        for (const std::string& scene : arguments_.scenes) {
            bar.show_now(0.0, "loading " + scene);
            const ViewedScene viewed =
                load_viewed(scene, arguments_.loading, arguments_.view, arguments_.build.options.thread_count);
            throw_if_interrupted();
            std::vector<TraceResult> of_scene =
                trace_scene(settings_, arguments_.rays, arguments_.tracing, scene, viewed, bar);
            bar.erase();
            report_.print_tables(trace_report(of_scene) + '\n');
            std::move(of_scene.begin(), of_scene.end(), std::back_inserter(results_));
        }
    }

    [[nodiscard]] const std::vector<TraceResult>& results() const { return results_; }

    [[nodiscard]] nlohmann::ordered_json document() const {
        nlohmann::ordered_json list = nlohmann::ordered_json::array();
        for (const TraceResult& result : results_)
            list.push_back(to_json(result));
        nlohmann::ordered_json document =
            document_json(choice_.context, arguments_.loading, arguments_.build.options, std::move(list));
        report_.add_unavailable(document);
        return document;
    }

private:
    const TraceArguments& arguments_;
    BuilderChoice choice_;
    SceneReport report_{choice_, arguments_.loading, arguments_.json};
    TraceSettings settings_;
    std::vector<TraceResult> results_;
};

/// What can be seen before any work.
void check_arguments(const TraceArguments& arguments) {
    arguments.build.check();
    arguments.view.check();
    arguments.json.require_writable();
    arguments.rays.check(arguments.scenes.size());
    std::ranges::for_each(arguments.scenes, require_scene);
}

int run_trace(const TraceArguments& arguments) {
    check_arguments(arguments);
    Tracing tracing(arguments);
    run_and_write(
        arguments.json, [&] { tracing.run(); }, [&] { return !tracing.results().empty(); },
        [&] { return tracing.document(); });
    return report_mismatches(tracing.results());
}

}  // namespace

Command add_trace_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand("trace", "Trace the same rays through the trees of several builders");
    command->footer(
        "Rays are made on the first tree; answers are compared with its own. binned-sah runs as well, to be compared "
        "with.\nTimes are of the wall clock, medians of rounds in which all trees take their turns.");
    auto arguments = std::make_shared<TraceArguments>();
    command->add_option("scene", arguments->scenes, kScenesHelp)->type_name("SCENE")->required();
    command
        ->add_option("--builders,--builder", arguments->builders,
                     "Ids or groups (all, host, device, presets) with commas between them; see clbvh builders")
        ->type_name("A,B,C")
        ->capture_default_str();
    command->add_option("--runs", arguments->runs, "Timed rounds, after one that warms up, 1 to 1000")
        ->check(CLI::Range(1, 1000))
        ->type_name("N")
        ->capture_default_str();
    arguments->rays.add_options(*command);
    arguments->tracing.add_options(*command);
    arguments->view.add_options(*command);
    arguments->loading.add_options(*command);
    arguments->build.add_options(*command);
    arguments->json.add_option(*command);
    return {command, [arguments] { return run_trace(*arguments); }};
}

}  // namespace clbvh::tool
