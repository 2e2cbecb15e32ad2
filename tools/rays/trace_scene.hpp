#pragma once

#include <clbvh/core/bvh.hpp>
#include <clbvh/core/mesh.hpp>
#include <clbvh/device/context.hpp>
#include <clbvh/options.hpp>
#include <clbvh/trace/tracer.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/progress_bar.hpp"
#include "measure/ray_engine.hpp"
#include "rays/ray_arguments.hpp"
#include "rays/tracer_arguments.hpp"
#include "rays/view_arguments.hpp"
#include "report/trace_result.hpp"

namespace clbvh::tool {

/// The settings of `clbvh trace`, the same for each scene.
struct TraceSettings {
    std::vector<std::string> builders;  ///< Ids, each once, the baseline among them.
    std::uint32_t runs = 5;
    BuildOptions options;
    std::optional<Context> context;  ///< Needed where a device builds or traces.
};

/// A tree that rays are traced through.
struct TraceCandidate {
    TraceResult base;  ///< What is the same for all rays.
    std::unique_ptr<RayEngine> engine;
};

/// Shown each tree before it goes; its engine is not there yet.
using VisitTree = std::function<void(const TraceResult& base, const Bvh& bvh)>;

/// The fields that are the same for all rays through `bvh`, but for where they are traced.
[[nodiscard]] TraceResult describe_candidate(const std::string& scene, const Mesh& mesh, std::string_view builder,
                                             BuilderKind kind, const Bvh& bvh);

/// An engine over the tree of `base`, which learns where that is.
[[nodiscard]] TraceCandidate make_candidate(TraceResult base, const Bvh& bvh, const Mesh& mesh,
                                            const TraceSettings& settings, const TracerArguments& tracing);

/// Builds a tree with each builder, and an engine over it.
[[nodiscard]] std::vector<TraceCandidate> build_candidates(const TraceSettings& settings,
                                                           const TracerArguments& tracing, const std::string& scene,
                                                           const Mesh& mesh, ProgressBar& bar,
                                                           const VisitTree& visit = {});

/// `base`, of one tree, with the cost of these rays.
[[nodiscard]] TraceResult result_of(const TraceResult& base, const RayArguments& arguments, const RaySet& set,
                                    const Camera& camera, const RayCost& cost);

/// Builds a tree with each builder and traces the same rays through all of them, in the same rounds. The rays are made
/// on the first tree.
[[nodiscard]] std::vector<TraceResult> trace_scene(const TraceSettings& settings, const RayArguments& rays,
                                                   const TracerArguments& tracing, const std::string& scene,
                                                   const ViewedScene& viewed, ProgressBar& bar);

}  // namespace clbvh::tool
