#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <clbvh/io/scene.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/exit_code.hpp"
#include "cli/json_output.hpp"
#include "commands/command.hpp"
#include "report/table.hpp"

namespace clbvh::tool {
namespace {

int print_scenes(const JsonOutput& json) {
    json.require_writable();
    Table table({"scene", "description"}, Table::Align::left);
    nlohmann::ordered_json entries = nlohmann::ordered_json::array();
    for (const SceneGeneratorInfo& generator : scene_generators()) {
        const SceneParameter& parameter = generator.parameter;
        nlohmann::ordered_json entry{{"name", generator.name}, {"description", generator.description}};
        if (parameter.name.empty()) {
            table.add_row({fmt::format("gen:{}", generator.name), std::string(generator.description)});
        } else {
            table.add_row({fmt::format("gen:{}[:{}]", generator.name, parameter.name),
                           fmt::format("{}; {}: {}, {} to {} ({} unless told)", generator.description, parameter.name,
                                       parameter.description, parameter.least, parameter.most, parameter.standard)});
            entry["parameter"] = {{"name", parameter.name},
                                  {"description", parameter.description},
                                  {"least", parameter.least},
                                  {"most", parameter.most},
                                  {"default", parameter.standard}};
        }
        entries.push_back(entry);
    }
    if (json.leaves_standard_output()) {
        fmt::print(
            "{}\nWritten gen:NAME[:COUNT[:SEED]], or gen:NAME:PARAMETER[:COUNT[:SEED]]; COUNT is {} unless told. A "
            "path to a mesh "
            "file is a scene too.\n",
            table.text(), kDefaultSceneTriangles);
    }
    json.write({{"scenes", entries}, {"default_triangles", kDefaultSceneTriangles}});
    return kExitSuccess;
}

}  // namespace

Command add_scenes_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand("scenes", "List the generated scenes");
    auto json = std::make_shared<JsonOutput>();
    json->add_option(*command);
    return {command, [json] { return print_scenes(*json); }};
}

}  // namespace clbvh::tool
