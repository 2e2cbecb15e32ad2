#pragma once

#include <clbvh/core/mesh.hpp>
#include <clbvh/eval/rotation.hpp>
#include <optional>
#include <string>

#include "cli/cli_fwd.hpp"

namespace clbvh::tool {

/// Help text of positional arguments that take scenes.
inline constexpr const char* kSceneHelp = "Mesh file, or gen:NAME[:COUNT[:SEED]]; see clbvh scenes";
inline constexpr const char* kScenesHelp = "Mesh files, or gen:NAME[:COUNT[:SEED]]; see clbvh scenes";

/// How a command takes its scenes in.
class SceneArguments {
public:
    /// Every scene is turned by so many degrees about the axis (1, 1, 1) through the origin, as Aila, Karras and Laine
    /// 2013 do in section 4.4 to see what boxes along axes are worth to scenes that are not. Rotation says why through
    /// the origin.
    double rotate_degrees = 0.0;

    /// Adds the options to a command; parsing fills this object.
    void add_options(CLI::App& command);
    /// The turn; nothing where there is none.
    [[nodiscard]] std::optional<Rotation> rotation() const;
    /// load_scene, with the scene turned.
    [[nodiscard]] Mesh load(const std::string& scene) const;
    /// A line for tables: "scenes turned by 45 degrees about (1, 1, 1)"; empty where they are not.
    [[nodiscard]] std::string note() const;
};

}  // namespace clbvh::tool
