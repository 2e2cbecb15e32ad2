#pragma once

#include <clbvh/core/mesh.hpp>
#include <clbvh/eval/camera.hpp>
#include <cstdint>
#include <string>

#include "cli/cli_fwd.hpp"
#include "cli/scene_arguments.hpp"

namespace clbvh::tool {

/// From where a command looks at its scenes.
class ViewArguments {
public:
    /// Adds the options to a command; parsing fills this object.
    void add_options(CLI::App& command);
    /// Throws Error(invalid_input) that names the option.
    void check() const;
    /// The camera that was asked for, else one that fits the scene before it is turned (fit_camera).
    /// On so many threads; 0: all. Throws Error(cancelled) after a Ctrl-C.
    [[nodiscard]] Camera camera(const Mesh& unturned, std::uint32_t thread_count) const;

private:
    std::string camera_;  // empty: one that fits
    std::string up_;      // empty: a guess
};

/// A scene as it is traced, and the camera that is turned with it.
struct ViewedScene {
    Mesh mesh;
    Camera camera;
    Camera unturned_camera;  ///< As --camera takes it.
};

[[nodiscard]] ViewedScene load_viewed(const std::string& scene, const SceneArguments& loading,
                                      const ViewArguments& view, std::uint32_t thread_count);

}  // namespace clbvh::tool
