#pragma once

#include <clbvh/core/mesh.hpp>
#include <clbvh/io/scene.hpp>
#include <string>

#include "cli/progress_bar.hpp"

namespace clbvh::tool {

/// load_scene, which a Ctrl-C ends. `report` may be null.
[[nodiscard]] Mesh load_cancellably(const std::string& scene, LoadReport* report = nullptr);
/// The same with a bar.
[[nodiscard]] Mesh load_with_progress(const std::string& scene, ProgressBar& bar, LoadReport* report = nullptr);

}  // namespace clbvh::tool
