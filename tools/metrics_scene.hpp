#pragma once

#include <clbvh/core/bvh.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "metrics_result.hpp"
#include "trace_scene.hpp"

namespace clbvh::tool {

/// What `clbvh metrics` does with each scene.
struct MetricsSettings {
    TraceSettings tracing;
    std::uint64_t epo_samples = 0;  ///< 0: exact.
};

/// Builds a tree with each builder, describes it, and traces the same rays through all of them, in the same rounds, and
/// once more through the trees' own nodes. The rays, of one kind, are made on the first tree.
[[nodiscard]] std::vector<MetricsResult> measure_scene(const MetricsSettings& settings, const RayArguments& rays,
                                                       const TracerArguments& tracing, const std::string& scene,
                                                       const ViewedScene& viewed, ProgressBar& bar);

}  // namespace clbvh::tool
