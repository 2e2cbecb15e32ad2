#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <clbvh/core/error.hpp>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/build_arguments.hpp"
#include "cli/builder_choice.hpp"
#include "cli/interrupt.hpp"
#include "cli/open_builder.hpp"
#include "cli/output_file.hpp"
#include "cli/progress_bar.hpp"
#include "cli/scene_arguments.hpp"
#include "cli/scene_check.hpp"
#include "cli/stopwatch.hpp"
#include "commands/command.hpp"
#include "rays/tracer_arguments.hpp"
#include "rays/view_arguments.hpp"
#include "render/heat_map.hpp"
#include "render/picture.hpp"
#include "render/render_modes.hpp"

namespace clbvh::tool {
namespace {

struct RenderArguments {
    std::string scene;
    SceneArguments loading;
    ViewArguments view;
    std::string builders = "binned-sah";
    TracerArguments tracing;
    RenderMode mode = RenderMode::path;
    RenderSettings settings;
    std::uint32_t samples = 0;  // 0: the mode's usual number
    float heat_end = 0.0f;
    std::string output;
    BuildArguments build;
};

constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 26;

/// Refuses wrong arguments before any work.
void check_arguments(const RenderArguments& arguments) {
    arguments.build.check();
    arguments.view.check();
    const std::uint64_t pixels = std::uint64_t{arguments.settings.width} * arguments.settings.height;
    if (pixels > kMostPixels) {
        throw Error(ErrorCode::invalid_input, fmt::format("--width, --height: {} pixels are more than {}; make the "
                                                          "picture smaller",
                                                          pixels, kMostPixels));
    }
    constexpr std::uint32_t most_aspect = 10000;
    const auto [short_side, long_side] = std::minmax(arguments.settings.width, arguments.settings.height);
    if (long_side / short_side >= most_aspect) {
        throw Error(ErrorCode::invalid_input, fmt::format("--width, --height: {} x {} is too narrow a picture",
                                                          arguments.settings.width, arguments.settings.height));
    }
    if (!std::isfinite(arguments.heat_end)) {
        throw Error(ErrorCode::invalid_input, "--heat-max: give it a number of visits");
    }
    require_scene(arguments.scene);
    require_writable(arguments.output);
}

/// Those of --builder, and where they run.
BuilderChoice choose(const RenderArguments& arguments) {
    BuilderChoice choice = choose_builders(arguments.builders, arguments.build.device, kOneBuilderWayOut);
    arguments.build.note_unread(choice.ids);
    choice.context = arguments.tracing.context(std::move(choice.context), arguments.build.device);
    if (choice.ids.size() > 1 && !shows_heat(arguments.mode)) {
        throw Error(ErrorCode::invalid_input,
                    fmt::format("--builder: pictures of mode {} do not depend on the tree; name one builder",
                                to_string(arguments.mode)));
    }
    const std::uint64_t pixels =
        std::uint64_t{arguments.settings.width} * arguments.settings.height * choice.ids.size();
    if (pixels > kMostPixels) {
        throw Error(ErrorCode::invalid_input,
                    fmt::format("--width, --height: {} pixels of {} pictures side by side are more than {}; make them "
                                "smaller",
                                pixels, choice.ids.size(), kMostPixels));
    }
    return choice;
}

std::unique_ptr<RayEngine> build_engine(const RenderArguments& arguments, const std::string& builder,
                                        const std::optional<Context>& context, const Mesh& mesh, ProgressBar& bar) {
    BuildOptions options = arguments.build.options;
    options.progress = [&bar](const Progress& build) {
        bar.show(build.fraction, "building the tree");
        return !interrupted();
    };
    const Bvh bvh = open_builder(builder, context, options).build(mesh);
    return arguments.tracing.engine(bvh, mesh, options, context);
}

/// A heat map for each builder, all to the same scale.
Picture draw_heat(const RenderArguments& arguments, const BuilderChoice& choice, const ViewedScene& viewed,
                  const RenderSettings& settings, ProgressBar& bar) {
    std::vector<std::vector<float>> heats;
    float scale_end = arguments.heat_end;
    for (const std::string& builder : choice.ids) {
        const std::unique_ptr<RayEngine> engine = build_engine(arguments, builder, choice.context, viewed.mesh, bar);
        heats.push_back(measure_heat(arguments.mode, viewed.camera, *engine, settings));
        if (arguments.heat_end == 0.0f) scale_end = std::max(scale_end, fitting_scale_end(heats.back()));
    }
    std::vector<Picture> maps;
    maps.reserve(heats.size());
    for (const std::vector<float>& heat : heats)
        maps.push_back(heat_map(heat, settings.width, settings.height, scale_end));
    return side_by_side(maps);
}

Picture draw(const RenderArguments& arguments, const BuilderChoice& choice, const ViewedScene& viewed,
             const RenderSettings& settings, ProgressBar& bar) {
    if (shows_heat(arguments.mode)) return draw_heat(arguments, choice, viewed, settings, bar);
    const std::unique_ptr<RayEngine> engine =
        build_engine(arguments, choice.ids.front(), choice.context, viewed.mesh, bar);
    return render(arguments.mode, viewed.mesh, viewed.camera, *engine, settings);
}

int render_scene(const RenderArguments& arguments) {
    check_arguments(arguments);
    const BuilderChoice choice = choose(arguments);
    ProgressBar bar;
    bar.show_now(0.0, "loading " + arguments.scene);
    const ViewedScene viewed =
        load_viewed(arguments.scene, arguments.loading, arguments.view, arguments.build.options.thread_count);
    throw_if_interrupted();

    RenderSettings settings = arguments.settings;
    settings.samples = arguments.samples > 0 ? arguments.samples : usual_samples(arguments.mode);
    settings.progress = [&bar](double fraction) {
        bar.show(fraction, "rendering");
        throw_if_interrupted();
    };
    const Stopwatch stopwatch;
    const Picture picture = draw(arguments, choice, viewed, settings, bar);
    const double seconds = stopwatch.milliseconds() / 1e3;
    throw_if_interrupted();
    write_file(arguments.output, png_bytes(picture));
    bar.erase();
    fmt::print("{}: {} x {}, {}, {} samples a pixel, {:.1f} s\n  --camera {}\n", arguments.output, picture.width(),
               picture.height(), to_string(arguments.mode), settings.samples, seconds,
               to_string(viewed.unturned_camera));
    return 0;
}

void add_picture_options(CLI::App& command, RenderArguments& arguments) {
    command
        .add_option_function<std::string>(
            "--mode", [&arguments](const std::string& name) { arguments.mode = render_mode_from(name).value(); },
            "path: lit by sky, sun or lamps; ao: ambient occlusion; normal: directions of surfaces; heat-nodes: nodes "
            "that rays visit; heat-leaves: leaves that rays would visit if nothing ended them")
        ->check(CLI::IsMember({"path", "ao", "normal", "heat-nodes", "heat-leaves"}))
        ->type_name("NAME")
        ->default_str("path");
    const CLI::Range side(std::uint32_t{1}, std::uint32_t{16384});
    command.add_option("--width", arguments.settings.width, "Pixels from left to right")
        ->check(side)
        ->type_name("N")
        ->capture_default_str();
    command.add_option("--height", arguments.settings.height, "Pixels from top to bottom")
        ->check(side)
        ->type_name("N")
        ->capture_default_str();
    command.add_option("--spp", arguments.samples, "Samples a pixel; 16 unless given, 4 of normals and 1 of heat")
        ->check(CLI::Range(std::uint32_t{1}, std::uint32_t{65536}))
        ->type_name("N");
    command.add_flag("!--no-denoise", arguments.settings.denoised,
                     "Leave the noise in path-traced pictures, which are smoothed where their samples disagree");
    command.add_option("--seed", arguments.settings.seed, "Of the samples")->type_name("N")->capture_default_str();
    command
        .add_option("--heat-max", arguments.heat_end,
                    "Visits at the bright end of a heat map, so that several compare; what 99 % of the pixels do not "
                    "exceed unless given")
        ->check(CLI::Range(1.0, 1e9))
        ->type_name("N");
    command.add_option("-o,--output", arguments.output, "The PNG file")
        ->type_name("FILE")
        ->required()
        ->check([](const std::string& value) { return value.empty() || value == "-" ? "-o needs a file" : ""; });
}

}  // namespace

Command add_render_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand("render", "Draw a scene, or what its tree costs");
    auto arguments = std::make_shared<RenderArguments>();
    command->add_option("scene", arguments->scene, kSceneHelp)->type_name("SCENE")->required();
    add_picture_options(*command, *arguments);
    command
        ->add_option("--builder,--builders", arguments->builders,
                     "See clbvh builders; heat maps of several, with commas between them, stand side by side")
        ->type_name("ID")
        ->capture_default_str();
    arguments->view.add_options(*command);
    arguments->tracing.add_options(*command);
    arguments->loading.add_options(*command);
    arguments->build.add_options(*command);
    return {command, [arguments] { return render_scene(*arguments); }};
}

}  // namespace clbvh::tool
