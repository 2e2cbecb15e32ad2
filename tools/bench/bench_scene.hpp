#pragma once

#include <clbvh/core/mesh.hpp>
#include <clbvh/device/context.hpp>
#include <clbvh/eval/camera.hpp>
#include <clbvh/options.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/progress_bar.hpp"
#include "cli/scene_arguments.hpp"
#include "measure/build_result.hpp"

namespace clbvh::tool {

/// The settings of a benchmark, the same for each scene.
struct BenchSettings {
    std::vector<std::string> builders;  ///< Ids, each once.
    bool peers = false;                 ///< Other libraries' builders stand beside them.
    std::uint32_t runs = 5;             ///< Timed runs of each builder.
    bool validated = true;
    BuildOptions options;
    std::optional<Context> context;  ///< Where device builders run; needed where there are any.
    SceneArguments loading;          ///< How a sweep over sizes takes its scenes in.
    std::optional<Camera> camera;    ///< Where rays are traced too: from where they come.
};

/// Times every builder, the native sort and, where there is a device, a copy on it in the same rounds (run_rounds) on
/// one mesh, and describes the last tree of each builder; with a camera also by what rays cost (bench_rays).
[[nodiscard]] std::vector<BuildResult> bench_scene(const BenchSettings& settings, std::string_view scene,
                                                   const Mesh& mesh, ProgressBar& bar);

}  // namespace clbvh::tool
