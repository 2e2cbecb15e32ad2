#include "commands/scene_command.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <nlohmann/json.hpp>
#include <utility>

#include "cli/interrupt.hpp"
#include "cli/scene_check.hpp"
#include "report/bench_report.hpp"
#include "report/result_json.hpp"

namespace clbvh::tool {

void SceneCommandArguments::add_scenes_and_builders(CLI::App& command, const std::string& builders_help) {
    command.add_option("scene", scenes, kScenesHelp)->type_name("SCENE")->required();
    command.add_option("--builders,--builder", builders, builders_help)->type_name("A,B,C")->capture_default_str();
}

void SceneCommandArguments::add_loading_and_building(CLI::App& command) {
    loading.add_options(command);
    build.add_options(command);
    json.add_option(command);
}

void SceneCommandArguments::check() const {
    build.check();
    json.require_writable();
    std::ranges::for_each(scenes, require_scene);
}

void RayCommandArguments::add_viewing_and_building(CLI::App& command) {
    view.add_options(command);
    add_loading_and_building(command);
}

void RayCommandArguments::check() const {
    view.check();
    rays.check(scenes.size());
    SceneCommandArguments::check();
}

SceneCommand::SceneCommand(const SceneCommandArguments& arguments, BuilderChoice choice)
    : arguments_(arguments), choice_(std::move(choice)), report_(choice_, arguments.loading, arguments.json) {}

std::string SceneCommand::opening() const {
    return unavailable_report(choice_);
}

int SceneCommand::run() {
    try {
        run_and_write(
            arguments_.json, [&] { run_scenes(); }, [&] { return !results().empty(); }, [&] { return document(); });
    } catch (const std::exception&) {
        static_cast<void>(report_faults());
        throw;
    }
    return report_faults();
}

void SceneCommand::run_scenes() {
    report_.print(opening());
    ProgressBar bar;
    for (const std::string& scene : arguments_.scenes) {
        const std::string tables = run_scene(scene, bar);
        bar.erase();
        report_.print_tables(tables + '\n');
    }
    report_.print(closing());
}

nlohmann::ordered_json SceneCommand::document() const {
    nlohmann::ordered_json document =
        document_json(choice_.context, arguments_.loading, arguments_.build.options, results());
    add_fields(document);
    report_.add_unavailable(document);
    return document;
}

std::string RaySceneCommand::run_scene(const std::string& scene, ProgressBar& bar) {
    bar.show_now(0.0, "loading " + scene);
    const ViewedScene viewed =
        load_viewed(scene, arguments_.loading, arguments_.view, arguments_.build.options.thread_count);
    throw_if_interrupted();
    return run_viewed(scene, viewed, bar);
}

}  // namespace clbvh::tool
