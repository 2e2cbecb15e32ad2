#pragma once

#include <clbvh/core/bvh.hpp>
#include <clbvh/core/mesh.hpp>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "rays/trace_scene.hpp"
#include "report/metrics_result.hpp"

namespace clbvh::tool {

/// The work of `clbvh metrics` for each scene.
struct MetricsSettings {
    TraceSettings tracing;
    std::uint64_t epo_samples = 0;  ///< 0: exact.
};

/// Properties of the tree of `base` alone: its statistics and its end-point overlap. `epo_samples` as in
/// MetricsSettings. Throws Error(cancelled) after a Ctrl-C.
[[nodiscard]] MetricsResult describe_metrics(const TraceResult& base, const Bvh& bvh, const Mesh& mesh,
                                             std::uint64_t epo_samples, ProgressBar& bar);

/// Traces the set through all candidates, in the same rounds, and once more through the trees' own nodes, and adds what
/// that cost to the result of each. Answers are compared with those of `reference`.
void measure_candidates(std::span<const TraceCandidate> candidates, RayEngine& reference, const RayArguments& rays,
                        const RaySet& set, const Camera& unturned_camera, std::size_t runs, ProgressBar& bar,
                        std::span<MetricsResult> results);

/// Builds a tree with each builder, describes it, and traces the same rays through all of them, in the same rounds, and
/// once more through the trees' own nodes. The rays, of one kind, are made on the first tree.
[[nodiscard]] std::vector<MetricsResult> measure_scene(const MetricsSettings& settings, const RayArguments& rays,
                                                       const TracerArguments& tracing, const std::string& scene,
                                                       const ViewedScene& viewed, ProgressBar& bar);

}  // namespace clbvh::tool
