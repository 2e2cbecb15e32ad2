#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <clbvh/core/error.hpp>
#include <clbvh/device/profile.hpp>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <vector>

#include "cli/exit_code.hpp"
#include "cli/json_output.hpp"
#include "cli/output_file.hpp"
#include "cli/progress_bar.hpp"
#include "cli/scene_check.hpp"
#include "commands/command.hpp"
#include "report/result_json.hpp"
#include "sweep/tuning.hpp"

namespace clbvh::tool {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

struct TuneArguments {
    std::string device;
    std::string output;
    TuneSettings settings{{"gen:clustered:300000", "gen:city:300000"}};
    JsonOutput json;
};

/// Where the profile goes; its folder is made.
fs::path output_path(const TuneArguments& arguments, const DeviceInfo& device) {
    if (!arguments.output.empty()) return arguments.output;
    fs::path path = profile_path(device);
    if (path.empty()) {
        throw Error(ErrorCode::io, "neither XDG_CONFIG_HOME nor HOME says where the profile belongs; use -o");
    }
    std::error_code ignored;  // require_writable() tells
    fs::create_directories(path.parent_path(), ignored);
    return path;
}

/// The profile, as its file has it.
ordered_json profile_json(const Profile& profile) {
    ordered_json json{
        {"platform", profile.platform}, {"device", profile.device}, {"driver_version", profile.driver_version}};
    if (profile.hand_over != HandOver::automatic) json["hand_over"] = to_string(profile.hand_over);
    if (profile.sort_shape != Shape::automatic) json["sort_shape"] = to_string(profile.sort_shape);
    if (profile.chunk_size != 0) json["chunk_size"] = profile.chunk_size;
    if (profile.work_group_size != 0) json["work_group_size"] = profile.work_group_size;
    if (profile.single_group_threshold != 0) json["single_group_threshold"] = profile.single_group_threshold;
    return json;
}

ordered_json trials_json(const TunedKnob& tuned, const TuneSettings& settings) {
    ordered_json trials = ordered_json::array();
    for (const Trial& trial : tuned.trials) {
        ordered_json times = ordered_json::array();
        for (std::size_t i = 0; i < trial.build_ms.size(); ++i) {
            const Sample& sample = trial.build_ms[i];
            times.push_back({{"scene", settings.scenes[i]},
                             {"build_ms", {{"median", sample.median}, {"min", sample.min}, {"max", sample.max}}}});
        }
        trials.push_back({{"value", value_text(tuned.knob, trial.value)},
                          {"scenes", std::move(times)},
                          {"relative", trial.relative},
                          {"chosen", trial.chosen}});
    }
    return {{"option", tuned.knob.option}, {"builder", tuned.knob.builder}, {"trials", std::move(trials)}};
}

std::string where_it_is_used(const TuneArguments& arguments, const fs::path& path) {
    if (arguments.output.empty()) return "from now on it is used on this device";
    return fmt::format("it is used where CLBVH_PROFILE={}", path.string());
}

int tune(const TuneArguments& arguments) {
    arguments.json.require_writable();
    for (const std::string& scene : arguments.settings.scenes)
        require_scene(scene);
    ContextOptions context_options;
    context_options.use_profile = false;
    const Context context = Context::open(arguments.device, context_options);
    const DeviceInfo& device = context.device();
    const fs::path path = output_path(arguments, device);
    require_writable(path);

    Profile profile{device.platform, device.name, device.driver_version};
    profile.hand_over = context.passes_hand_over_check() ? HandOver::within_launch : HandOver::between_launches;
    BuildOptions options;
    ordered_json tried = ordered_json::array();
    if (arguments.json.leaves_standard_output()) fmt::print("{}\n\n", hand_over_report(profile.hand_over));
    ProgressBar bar;
    for (const Knob& knob : knobs_of(context)) {
        const TunedKnob tuned = tune_knob(knob, arguments.settings, context, options, bar);
        knob.set(options, chosen_value(tuned));
        knob.keep(profile, chosen_value(tuned));
        tried.push_back(trials_json(tuned, arguments.settings));
        if (!arguments.json.leaves_standard_output()) continue;
        fmt::print("{}", tuning_report(tuned, arguments.settings));
        std::fflush(stdout);
    }
    write_file(path, profile_text(profile));
    if (arguments.json.leaves_standard_output()) {
        fmt::print("wrote {}; {}\n", path.string(), where_it_is_used(arguments, path));
    }
    arguments.json.write({{"device", to_json(device)},
                          {"rotate_degrees", arguments.settings.loading.rotate_degrees},
                          {"runs", arguments.settings.runs},
                          {"tried", std::move(tried)},
                          {"profile", profile_json(profile)},
                          {"file", path.string()}});
    return kExitSuccess;
}

}  // namespace

Command add_tune_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand("tune", "Find the best sizes for a device, and keep them in a profile");
    command->footer(
        "Nothing has to be tuned: the defaults are good. A profile lays work out differently and never changes a "
        "tree;\n"
        "options that are given win over it. It is used for this device with this driver: where it is in its place\n"
        "(clbvh devices shows it), or the variable CLBVH_PROFILE names it. CLBVH_PROFILE=off uses none.");
    auto arguments = std::make_shared<TuneArguments>();
    command->add_option("scene", arguments->settings.scenes, kScenesHelp)->type_name("SCENE")->capture_default_str();
    arguments->settings.loading.add_options(*command);
    command->add_option("--device", arguments->device, "Index, type (gpu, cpu, accelerator) or part of a name")
        ->type_name("D");
    command->add_option("--runs", arguments->settings.runs, "Timed runs of each value, after one that warms up")
        ->type_name("N")
        ->check(CLI::Range(std::uint32_t{1}, std::uint32_t{1000}))
        ->capture_default_str();
    command->add_option("-o,--output", arguments->output, "Write the profile to this file, not to its place")
        ->type_name("FILE");
    arguments->json.add_option(*command);
    return {command, [arguments] { return tune(*arguments); }};
}

}  // namespace clbvh::tool
