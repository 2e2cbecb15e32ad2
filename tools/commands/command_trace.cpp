#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "commands/command.hpp"
#include "commands/scene_command.hpp"
#include "rays/trace_scene.hpp"
#include "report/trace_result.hpp"

namespace clbvh::tool {
namespace {

struct TraceArguments : RayCommandArguments {
    std::uint32_t runs = 5;
};

/// The builders that were asked for, and the one that all are compared with.
BuilderChoice choose_for_trace(const TraceArguments& arguments) {
    BuilderChoice choice = choose_builders(arguments.builders, arguments.build.device, kBuildersWayOut);
    arguments.build.note_unread(choice.ids);
    choice.context = arguments.tracing.context(std::move(choice.context), arguments.build.device);
    if (std::ranges::find(choice.ids, kTraceBaseline) == choice.ids.end()) choice.ids.emplace_back(kTraceBaseline);
    return choice;
}

class Tracing final : public RaySceneCommand {
public:
    explicit Tracing(const TraceArguments& arguments)
        : RaySceneCommand(arguments, choose_for_trace(arguments)),
          arguments_(arguments),
          settings_{choice().ids, arguments.runs, arguments.build.options, choice().context} {}

private:
    std::string run_viewed(const std::string& scene, const ViewedScene& viewed, ProgressBar& bar) override {
        std::vector<TraceResult> of_scene =
            trace_scene(settings_, arguments_.rays, arguments_.tracing, scene, viewed, bar);
        std::string tables = trace_report(of_scene);
        std::ranges::move(of_scene, std::back_inserter(results_));
        return tables;
    }

    [[nodiscard]] nlohmann::ordered_json results() const override {
        nlohmann::ordered_json list = nlohmann::ordered_json::array();
        for (const TraceResult& result : results_)
            list.push_back(to_json(result));
        return list;
    }

    [[nodiscard]] int report_faults() const override { return report_mismatches(results_); }

    const TraceArguments& arguments_;
    TraceSettings settings_;
    std::vector<TraceResult> results_;
};

int run_trace(const TraceArguments& arguments) {
    arguments.check();
    return Tracing(arguments).run();
}

}  // namespace

Command add_trace_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand("trace", "Trace the same rays through the trees of several builders");
    command->footer(
        "Rays are made on the first tree; answers are compared with its own. binned-sah runs as well, to be compared "
        "with.\nTimes are of the wall clock, medians of rounds in which all trees take their turns.");
    auto arguments = std::make_shared<TraceArguments>();
    arguments->add_scenes_and_builders(*command, kBuildersHelp);
    command->add_option("--runs", arguments->runs, "Timed rounds, after one that warms up, 1 to 1000")
        ->check(CLI::Range(1, 1000))
        ->type_name("N")
        ->capture_default_str();
    arguments->rays.add_options(*command);
    arguments->tracing.add_options(*command);
    arguments->add_viewing_and_building(*command);
    return {command, [arguments] { return run_trace(*arguments); }};
}

}  // namespace clbvh::tool
