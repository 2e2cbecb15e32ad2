#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <clbvh/eval/mesh_info.hpp>
#include <clbvh/io/scene.hpp>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/exit_code.hpp"
#include "cli/json_output.hpp"
#include "cli/load.hpp"
#include "cli/progress_bar.hpp"
#include "cli/scene_arguments.hpp"
#include "cli/scene_check.hpp"
#include "commands/command.hpp"
#include "report/table.hpp"

namespace clbvh::tool {
namespace {

struct InfoArguments {
    std::vector<std::string> scenes;
    JsonOutput json;
};

nlohmann::ordered_json corner_json(const Vec3& v) {
    return {v.x, v.y, v.z};
}

nlohmann::ordered_json info_json(const std::string& scene, const MeshInfo& info, const LoadReport& report) {
    nlohmann::ordered_json result{{"scene", scene},
                                  {"triangles", info.triangles},
                                  {"vertices", info.vertices},
                                  {"meshes", report.meshes},
                                  {"instances", report.instances},
                                  {"faces", report.faces},
                                  {"skipped_faces", report.skipped_faces},
                                  {"points_and_lines", report.points_and_lines},
                                  {"overlapping_fans", report.overlapping_fans},
                                  {"inactive", info.inactive},
                                  {"out_of_range", info.out_of_range},
                                  {"zero_area", info.zero_area},
                                  {"duplicates", info.duplicates},
                                  {"area", info.area},
                                  {"bounds", nullptr}};
    if (info.bounds.lower.x <= info.bounds.upper.x)
        result["bounds"] = {{"lower", corner_json(info.bounds.lower)}, {"upper", corner_json(info.bounds.upper)}};
    return result;
}

std::string text_of(const Vec3& v) {
    return fmt::format("{:g} {:g} {:g}", v.x, v.y, v.z);
}

/// What is as it should be is left out.
std::string info_text(const std::string& scene, const MeshInfo& info, const LoadReport& report) {
    Table table({scene, ""}, Table::Align::left);
    const auto add = [&](const char* name, const std::string& value) { table.add_row({name, value}); };
    const auto add_if_any = [&](const char* name, std::uint64_t count, const char* meaning) {
        if (count > 0) add(name, fmt::format("{}, {}", count, meaning));
    };
    add("triangles", std::to_string(info.triangles));
    add("vertices", std::to_string(info.vertices));
    if (report.meshes != 1 || report.instances != 1)
        add("meshes", fmt::format("{}, at {} places", report.meshes, report.instances));
    if (report.faces != info.triangles) add("faces", std::to_string(report.faces));
    add("area", fmt::format("{:g}", info.area));
    if (info.bounds.lower.x <= info.bounds.upper.x)
        add("bounds", text_of(info.bounds.lower) + " .. " + text_of(info.bounds.upper));
    add_if_any("skipped faces", report.skipped_faces, "of fewer than three corners");
    add_if_any("points and lines", report.points_and_lines, "skipped");
    add_if_any("overlapping fans", report.overlapping_fans, "polygons that intersect themselves or hold a NaN");
    add_if_any("inactive", info.inactive, "with a NaN: in no tree");
    add_if_any("out of range", info.out_of_range, "with a coordinate beyond 1e18: no tree can be built");
    add_if_any("zero area", info.zero_area, "never hit by a ray");
    add_if_any("duplicates", info.duplicates, "with the corners of an earlier one");
    return table.text();
}

int print_info(const InfoArguments& arguments) {
    arguments.json.require_writable();
    for (const std::string& scene : arguments.scenes)
        require_scene(scene);
    nlohmann::ordered_json entries = nlohmann::ordered_json::array();
    ProgressBar bar;
    for (const std::string& scene : arguments.scenes) {
        LoadReport report;
        const Mesh mesh = load_with_progress(scene, bar, &report);
        const MeshInfo info = mesh_info(mesh);
        bar.erase();
        if (arguments.json.leaves_standard_output()) fmt::print("{}\n", info_text(scene, info, report));
        entries.push_back(info_json(scene, info, report));
    }
    arguments.json.write({{"scenes", entries}});
    return kExitSuccess;
}

}  // namespace

Command add_info_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand("info", "Say what a mesh file holds, and what is wrong with it");
    auto arguments = std::make_shared<InfoArguments>();
    command->add_option("scenes", arguments->scenes, kScenesHelp)->type_name("SCENE")->required();
    arguments->json.add_option(*command);
    return {command, [arguments] { return print_info(*arguments); }};
}

}  // namespace clbvh::tool
