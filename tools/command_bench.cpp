#include <fmt/core.h>

#include <algorithm>
#include <clbvh/io/scene.hpp>
#include <clbvh/registry.hpp>
#include <cstddef>
#include <cstdio>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "bench_report.hpp"
#include "bench_scene.hpp"
#include "build_arguments.hpp"
#include "build_result.hpp"
#include "command.hpp"
#include "json_output.hpp"
#include "progress_bar.hpp"
#include "result_json.hpp"

namespace clbvh::tool {
namespace {

struct Arguments {
    std::vector<std::string> scenes;
    std::string builders = "all";
    std::uint32_t runs = 5;
    bool unvalidated = false;
    BuildArguments build;
    JsonOutput json;
};

/// The ids that "a,b,c" or "all" stands for, each once. Throws what find_builder throws.
std::vector<std::string> builder_ids(const std::string& list) {
    std::vector<std::string> ids;
    if (list == "all") {
        for (const BuilderInfo& builder : builders())
            ids.emplace_back(builder.id);
        return ids;
    }
    for (std::size_t begin = 0; begin <= list.size();) {
        const std::size_t end = std::min(list.find(',', begin), list.size());
        const std::string id(find_builder(std::string_view(list).substr(begin, end - begin)).id);
        if (std::find(ids.begin(), ids.end(), id) == ids.end()) ids.push_back(id);
        begin = end + 1;
    }
    return ids;
}

int bench(const Arguments& arguments) {
    check_options(arguments.build.options);
    const BenchSettings settings{builder_ids(arguments.builders), arguments.runs, !arguments.unvalidated,
                                 arguments.build.options};
    arguments.json.require_writable();
    const Context context = Context::open(arguments.build.device);
    const bool print = arguments.json.leaves_standard_output();
    ProgressBar bar;
    std::vector<BuildResult> results;
    for (const std::string& scene : arguments.scenes) {
        bar.show(0.0, "loading " + scene);
        const Mesh mesh = load_scene(scene);
        std::vector<BuildResult> of_scene = bench_scene(settings, context, scene, mesh, bar);
        bar.erase();
        if (print) fmt::print("{}\n", scene_report(context.device(), of_scene));
        std::fflush(stdout);
        std::move(of_scene.begin(), of_scene.end(), std::back_inserter(results));
    }
    if (print && arguments.scenes.size() > 1) {
        fmt::print("geometric means over {} scenes\n{}", arguments.scenes.size(),
                   means_report(results, settings.builders.size()));
    }
    arguments.json.write(to_json(context.device(), results));
    return report_invalid_trees(results);
}

}  // namespace

Command add_bench_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand("bench", "Time builders side by side, and a native sort beside them");
    auto arguments = std::make_shared<Arguments>();
    command->add_option("scene", arguments->scenes, "Mesh files, or gen:NAME[:COUNT[:SEED]]; see clbvh scenes")
        ->type_name("SCENE")
        ->required();
    command->add_option("--builders", arguments->builders, "Ids with commas between them, or all; see clbvh builders")
        ->type_name("A,B,C")
        ->capture_default_str();
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
