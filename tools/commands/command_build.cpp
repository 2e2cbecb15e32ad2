#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <clbvh/builder.hpp>
#include <clbvh/io/bvh_file.hpp>
#include <clbvh/io/layout_file.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>

#include "cli/build_arguments.hpp"
#include "cli/builder_choice.hpp"
#include "cli/complain.hpp"
#include "cli/interrupt.hpp"
#include "cli/json_output.hpp"
#include "cli/layout_choice.hpp"
#include "cli/open_builder.hpp"
#include "cli/output_file.hpp"
#include "cli/progress_bar.hpp"
#include "cli/scene_arguments.hpp"
#include "cli/stopwatch.hpp"
#include "commands/command.hpp"
#include "measure/build_result.hpp"
#include "report/build_report.hpp"
#include "report/result_json.hpp"

namespace clbvh::tool {
namespace {

struct BuildCommandArguments {
    std::string scene;
    SceneArguments loading;
    std::string builder = "plocpp";
    BuildArguments build;
    bool validate = false;
    std::string output;
    std::string layout;  // empty where the tree itself is written
    JsonOutput json;
};

/// Checks that need no mesh come first: loading one may take long.
void check_arguments(const BuildCommandArguments& arguments) {
    arguments.build.check();
    static_cast<void>(require_builder(arguments.builder));
    arguments.json.require_writable();
    if (!arguments.output.empty()) require_writable(arguments.output);
}

/// Builds twice: some drivers compile a kernel only when it is first launched, and times are without compilation.
Bvh build_twice(const BuildCommandArguments& arguments, const std::optional<Context>& context, const Mesh& mesh,
                BuildResult& result) {
    constexpr double kRuns = 2.0;
    ProgressBar bar;
    double finished_runs = 0.0;
    BuildOptions options = arguments.build.options;
    options.progress = [&](const Progress& progress) {
        bar.show((finished_runs + progress.fraction) / kRuns, progress.stage);
        return !interrupted();
    };
    const Stopwatch first_build;
    Builder builder = open_builder(arguments.builder, context, options);
    builder.upload(mesh);
    builder.run();
    const double first_build_ms = first_build.milliseconds();
    finished_runs = 1.0;
    const BuildStats stats = builder.run();
    describe_builder(result, builder);
    summarize_runs(result, std::span(&stats, 1));
    result.scene = arguments.scene;
    result.first_build_ms = first_build_ms;
    return builder.download();
}

template <typename Layout>
void lay_out(const Bvh& bvh, const Mesh& mesh, Layout& layout, const LayoutOptions& options) {
    if constexpr (requires { layout.primitive_ids; }) {
        make_layout(bvh, layout, options);
    } else {
        make_layout(bvh, mesh, layout, options);
    }
}

/// Returns what the report says of it.
std::string write_output(const BuildCommandArguments& arguments, const Bvh& bvh, const Mesh& mesh) {
    if (arguments.layout.empty()) {
        write_bvh(bvh, arguments.output);
        return arguments.output;
    }
    const BuildOptions options = with_preset(arguments.builder, arguments.build.options);
    with_layout(layout_kind(arguments.layout), [&](auto layout) {
        lay_out(bvh, mesh, layout, {.thread_count = options.thread_count, .opening = options.opening});
        if (arguments.validate) validate(layout, mesh);
        write_layout(layout, arguments.output);
    });
    return arguments.output + ", " + arguments.layout;
}

int build(const BuildCommandArguments& arguments) {
    check_arguments(arguments);
    const BuilderChoice choice = choose_builders(arguments.builder, arguments.build.device, kOneBuilderWayOut);
    const std::optional<Context>& context = choice.context;
    arguments.build.note_unread(choice.ids);
    if (arguments.layout.empty() && arguments.build.options.opening != BuildOptions().opening)
        complain("note: --opening changes nothing here without --layout");
    const Stopwatch load;
    const Mesh mesh = arguments.loading.load(arguments.scene);
    const double load_ms = load.milliseconds();
    throw_if_interrupted();

    BuildResult result;
    const Bvh bvh = build_twice(arguments, context, mesh, result);
    describe_tree(result, bvh, mesh, arguments.validate);
    throw_if_interrupted();
    const bool is_written = result.valid.value_or(true) && !arguments.output.empty();
    const std::string output = is_written ? write_output(arguments, bvh, mesh) : "";
    if (arguments.json.leaves_standard_output())
        fmt::print("{}", build_report(context, arguments.loading, result, load_ms, output));
    const std::span<const BuildResult> results(&result, 1);
    arguments.json.write(document_json(context, arguments.loading, arguments.build.options, to_json(results)));
    return report_invalid_trees(results);
}

std::string require_file_name(const std::string& value) {
    return value.empty() || value == "-" ? "-o needs a file" : "";
}

}  // namespace

Command add_build_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand("build", "Build a tree over one scene");
    command->footer(
        "Builds twice and reports the second time: the first build warms up, since drivers compile kernels at their "
        "first\nlaunch, and memory is slower when it is first touched.");
    auto arguments = std::make_shared<BuildCommandArguments>();
    command->add_option("scene", arguments->scene, kSceneHelp)->type_name("SCENE")->required();
    command->add_option("--builder", arguments->builder, "A builder or a preset; see clbvh builders")
        ->type_name("ID")
        ->capture_default_str();
    arguments->loading.add_options(*command);
    arguments->build.add_options(*command);
    CLI::Option* output =
        command->add_option("-o,--output", arguments->output, "Write the tree to this file, which clbvh dump shows")
            ->type_name("FILE")
            ->check(require_file_name);
    command->add_option("--layout", arguments->layout, "Write this layout of the tree in its place")
        ->needs(output)
        ->check(CLI::IsMember({"wide8", "wide4", "compressed8", "pair", "skip"}));
    command->add_flag("--validate", arguments->validate,
                      "Prove the tree right, and its layout; exit code 3 where the tree is not");
    arguments->json.add_option(*command);
    return {command, [arguments] { return build(*arguments); }};
}

}  // namespace clbvh::tool
