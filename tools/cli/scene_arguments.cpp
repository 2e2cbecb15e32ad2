#include "cli/scene_arguments.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <utility>

#include "cli/load.hpp"

namespace clbvh::tool {
namespace {

constexpr Vec3 kAxis{1.0f, 1.0f, 1.0f};

/// CLI11 takes an empty word for 0, and knows the words for infinity and NaN.
std::string require_finite(const std::string& value) {
    double number = 0.0;
    const bool read = !value.empty() && CLI::detail::lexical_cast(value, number);
    return read && std::isfinite(number) ? "" : "needs a number of degrees";
}

}  // namespace

void SceneArguments::add_options(CLI::App& command) {
    command
        .add_option(
            "--rotate", rotate_degrees,
            "Turn every scene about the axis (1, 1, 1) through the origin, which boxes along the axes suffer from")
        ->check(require_finite)
        ->type_name("DEGREES");
}

std::optional<Rotation> SceneArguments::rotation() const {
    if (rotate_degrees == 0.0) return {};
    return Rotation(kAxis, rotate_degrees);
}

Mesh SceneArguments::load(const std::string& scene) const {
    Mesh mesh = load_cancellably(scene);
    const std::optional<Rotation> turn = rotation();
    return turn ? rotated(std::move(mesh), *turn) : mesh;
}

std::string SceneArguments::note() const {
    return rotate_degrees == 0.0 ? "" : fmt::format("scenes turned by {} degrees about (1, 1, 1)", rotate_degrees);
}

}  // namespace clbvh::tool
