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
#include "commands/command.hpp"
#include "commands/scene_command.hpp"
#include "rays/measuring_arguments.hpp"
#include "report/cost_prediction.hpp"

namespace clbvh::tool {
namespace {

/// Of `tracing` only the triangle test is asked for.
struct TableArguments : RayCommandArguments {
    MeasuringArguments measuring;
    AnnealConfig annealing;
};

constexpr std::uint32_t kPaperLeaf = 8;
constexpr const char* kWayOut = "--builders bbvh,sbvh,agglo needs no device";

/// The device that builders need; where none does, one to trace on if there is any.
BuilderChoice open_device(const std::string& builders, const std::string& device) {
    std::string ids;
    for (const AilaBuilder& each : choose_aila_builders(builders))
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

class Comparing final : public RaySceneCommand {
public:
    explicit Comparing(const TableArguments& arguments)
        : RaySceneCommand(arguments, open_device(arguments.builders, arguments.build.device)), arguments_(arguments) {
        settings_.builders = choose_aila_builders(arguments.builders);
        settings_.trees = {arguments.build.options, arguments.annealing, choice().context};
        settings_.runs = arguments.measuring.runs;
        settings_.epo_samples = arguments.measuring.epo_samples;
        settings_.triangle_test = arguments.tracing.triangle_test;
        settings_.traces_on_device = choice().context.has_value();
    }

private:
    [[nodiscard]] std::string opening() const override {
        if (settings_.traces_on_device) return {};
        return "rays are traced on the host only: " + choice().reason + '\n';
    }

    std::string run_viewed(const std::string& scene, const ViewedScene& viewed, ProgressBar& bar) override {
        scenes_.push_back(measure_aila_scene(settings_, arguments_.rays, scene, viewed, bar));
        std::vector<Prediction> predictions = predict(scenes_.back());
        std::string tables = aila_report(scenes_.back(), predictions);
        std::ranges::move(predictions, std::back_inserter(predictions_));
        return tables;
    }

    [[nodiscard]] std::string closing() const override { return pooled_report(predictions_); }

    [[nodiscard]] nlohmann::ordered_json results() const override {
        nlohmann::ordered_json list = nlohmann::ordered_json::array();
        for (const AilaScene& scene : scenes_) {
            for (nlohmann::ordered_json& result : to_json(scene))
                list.push_back(std::move(result));
        }
        return list;
    }

    void add_fields(nlohmann::ordered_json& document) const override {
        document["anneal_passes"] = arguments_.annealing.length;
        document["correlation"] = to_json(predictions_);
        if (!settings_.traces_on_device) document["no_device"] = choice().reason;
    }

    [[nodiscard]] int report_faults() const override {
        std::vector<TraceResult> traces;
        for (const AilaScene& scene : scenes_) {
            std::ranges::transform(scene.host, std::back_inserter(traces), &MetricsResult::trace);
            std::ranges::transform(scene.device, std::back_inserter(traces), &MetricsResult::trace);
        }
        return report_mismatches(traces);
    }

    const TableArguments& arguments_;
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

int run_table(const TableArguments& arguments) {
    check_splitting(arguments);
    require_one_kind(arguments.rays, "the table is");
    arguments.check();
    return Comparing(arguments).run();
}

void add_measuring_options(CLI::App& command, TableArguments& arguments) {
    arguments.add_scenes_and_builders(command,
                                      "all, or some of lbvh, bbvh, sbvh, agglo, bittner, hclimb, anneal, treelet and "
                                      "streelet, with commas between them");
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
    add_measuring_options(*command, *arguments);
    arguments->rays.add_options(*command);
    arguments->tracing.add_triangle_test(*command);
    arguments->add_viewing_and_building(*command);
    for (const char* option : {"--optimize", "--optimize-passes", "--optimize-on"})
        command->remove_option(command->get_option(option));  // each of the nine has its own
    return {command, [arguments] { return run_table(*arguments); }};
}

}  // namespace clbvh::tool
