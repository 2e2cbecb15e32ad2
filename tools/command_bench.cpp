#include <fmt/core.h>

#include <clbvh/io/scene.hpp>
#include <cstdio>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bench_report.hpp"
#include "bench_scene.hpp"
#include "build_arguments.hpp"
#include "build_result.hpp"
#include "builder_choice.hpp"
#include "command.hpp"
#include "embree_peer.hpp"
#include "json_output.hpp"
#include "progress_bar.hpp"
#include "result_json.hpp"

namespace clbvh::tool {
namespace {

struct Arguments {
    std::vector<std::string> scenes;
    std::string builders = "all";
    bool peers = false;
    std::uint32_t runs = 5;
    bool unvalidated = false;
    BuildArguments build;
    JsonOutput json;
};

/// The document, with "unavailable" in it where some builders are.
nlohmann::ordered_json document_of(const BuilderChoice& choice, std::span<const BuildResult> results) {
    nlohmann::ordered_json document = to_json(choice.context, results);
    for (const std::string& id : choice.unavailable_ids)
        document["unavailable"].push_back({{"builder", id}, {"reason", choice.reason}});
    return document;
}

int bench(const Arguments& arguments) {
    arguments.build.check();
    if (arguments.peers) check_embree_peers(arguments.build.options);
    arguments.json.require_writable();
    const BuilderChoice choice = choose_builders(arguments.builders, arguments.build.device);
    const BenchSettings settings{
        choice.ids, arguments.peers, arguments.runs, !arguments.unvalidated, arguments.build.options, choice.context};
    const bool print = arguments.json.leaves_standard_output();
    if (print) fmt::print("{}", unavailable_report(choice));
    ProgressBar bar;
    std::vector<BuildResult> results;
    for (const std::string& scene : arguments.scenes) {
        bar.show(0.0, "loading " + scene);
        const Mesh mesh = load_scene(scene);
        std::vector<BuildResult> of_scene = bench_scene(settings, scene, mesh, bar);
        bar.erase();
        if (print) fmt::print("{}\n", scene_report(choice.context, of_scene));
        std::fflush(stdout);
        std::move(of_scene.begin(), of_scene.end(), std::back_inserter(results));
    }
    if (print && arguments.scenes.size() > 1) {
        fmt::print("geometric means over {} scenes\n{}", arguments.scenes.size(),
                   means_report(results, results.size() / arguments.scenes.size()));
    }
    arguments.json.write(document_of(choice, results));
    return report_invalid_trees(results);
}

}  // namespace

Command add_bench_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand("bench", "Time builders side by side, and a native sort beside them");
    auto arguments = std::make_shared<Arguments>();
    command->add_option("scene", arguments->scenes, "Mesh files, or gen:NAME[:COUNT[:SEED]]; see clbvh scenes")
        ->type_name("SCENE")
        ->required();
    command
        ->add_option("--builders", arguments->builders,
                     "Ids or groups (all, host, device) with commas between them; see clbvh builders")
        ->type_name("A,B,C")
        ->capture_default_str();
    command->add_flag("--peers", arguments->peers, "Add Embree's builders, as host builders with the same options");
    command->add_option("--runs", arguments->runs, "Timed runs of each builder, after one that warms up")
        ->type_name("N")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    command->add_flag("--no-validate", arguments->unvalidated, "Do not prove the trees right");
    arguments->build.add_options(*command);
    arguments->json.add_option(*command);
    return {command, [arguments] { return bench(*arguments); }};
}

}  // namespace clbvh::tool
