#include "rays/view_arguments.hpp"

#include <CLI/CLI.hpp>
#include <clbvh/builder.hpp>
#include <clbvh/core/error.hpp>
#include <clbvh/eval/rotation.hpp>
#include <clbvh/trace/tracer.hpp>
#include <optional>
#include <utility>

#include "cli/interrupt.hpp"
#include "cli/load.hpp"

namespace clbvh::tool {
namespace {

Camera turned(const Camera& camera, const Rotation& rotation) {
    return {rotation(camera.eye), rotation(camera.target), rotation(camera.up), camera.field_of_view};
}

/// `parse` of an option's value, with the option's name in what it throws.
template <typename Parse>
auto parse_option(const char* name, const Parse& parse) {
    try {
        return parse();
    } catch (const Error& error) {
        throw Error(error.code(), std::string(name) + ": " + error.what());
    }
}

}  // namespace

void ViewArguments::add_options(CLI::App& command) {
    command
        .add_option("--camera", camera_,
                    "Eye x,y,z, target x,y,z and, where liked, the vertical field of view in degrees (45 unless "
                    "given), in the scene before it is turned; a fitting view unless given")
        ->type_name("EX,EY,EZ,TX,TY,TZ[,FOV]");
    command.add_option("--up", up_, "What is up in the scene: x, y, z, -x, -y or -z; a guess unless given")
        ->type_name("AXIS");
}

void ViewArguments::check() const {
    const Vec3 up = parse_option("--up", [&] { return parse_axis(up_.empty() ? "y" : up_); });
    if (!camera_.empty()) static_cast<void>(parse_option("--camera", [&] { return parse_camera(camera_, up); }));
}

Camera ViewArguments::camera(const Mesh& unturned, std::uint32_t thread_count) const {
    const Vec3 up = up_.empty() ? guess_up(unturned) : parse_axis(up_);
    if (!camera_.empty()) return parse_camera(camera_, up);
    BuildOptions options;
    options.thread_count = thread_count;
    options.progress = [](const Progress&) { return !interrupted(); };
    TracerOptions tracing;
    tracing.thread_count = thread_count;
    const Tracer tracer(Builder("binned-sah", options).build(unturned), unturned, tracing);
    return fit_camera(unturned, up, closest_hits_of(tracer));
}

ViewedScene load_viewed(const std::string& scene, const SceneArguments& loading, const ViewArguments& view,
                        std::uint32_t thread_count) {
    Mesh mesh = load_cancellably(scene);
    const Camera camera = view.camera(mesh, thread_count);
    const std::optional<Rotation> rotation = loading.rotation();
    if (!rotation) return {std::move(mesh), camera, camera};
    return {rotated(std::move(mesh), *rotation), turned(camera, *rotation), camera};
}

}  // namespace clbvh::tool
