#pragma once

#include <clbvh/core/build_options.hpp>
#include <clbvh/device/context.hpp>
#include <clbvh/trace/tracer.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "progress_bar.hpp"
#include "ray_arguments.hpp"
#include "trace_result.hpp"
#include "tracer_arguments.hpp"
#include "view_arguments.hpp"

namespace clbvh::tool {

/// What `clbvh trace` does with each scene.
struct TraceSettings {
    std::vector<std::string> builders;  ///< Ids, each once, the baseline among them.
    std::uint32_t runs = 5;
    BuildOptions options;
    std::optional<Context> context;  ///< Needed where a device builds or traces.
};

/// Builds a tree with each builder and traces the same rays through all of them, in the same rounds. The rays are made
/// on the first tree.
[[nodiscard]] std::vector<TraceResult> trace_scene(const TraceSettings& settings, const RayArguments& rays,
                                                   const TracerArguments& tracing, const std::string& scene,
                                                   const ViewedScene& viewed, ProgressBar& bar);

}  // namespace clbvh::tool
