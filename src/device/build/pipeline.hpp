#pragma once

#include "device/build/device_algorithm.hpp"
#include "device/opencl/device_memory.hpp"
#include "device/tree/optimize.hpp"

namespace clbvh::device {

/// Resolves the options, and builds the programs that run_pipeline() will use with them. Throws what resolve_settings
/// and Session::prepare throw.
[[nodiscard]] BuildSettings prepare_pipeline(Session& session, const DeviceAlgorithm& algorithm,
                                             const BuildOptions& options);

/// The memory of a build over `primitives`.
[[nodiscard]] MemoryPlan plan_pipeline(const DeviceAlgorithm& algorithm, const BuildSettings& settings,
                                       std::uint32_t primitives);

/// A build in memory of the caller's.
struct CallerBuild {
    DeviceMesh mesh;  ///< without primitives nothing is built
    MemoryPlan plan;
    BuildMemory memory;
    Block active_count;  ///< where to put the number of active primitives; may have no buffer
    Block kept_count;    ///< where that number outlives the scratch; may have no buffer
};

/// Enqueues a build, and waits for nothing that the algorithm need not wait for.
void enqueue_pipeline(Launcher& launcher, const DeviceAlgorithm& algorithm, const BuildSettings& settings,
                      const CallerBuild& build);

/// What improves a tree behind its build, and memory for that.
struct PipelineEnd {
    OptimizerChain optimizers;
    KeptBuffer scratch;
};

/// Builds from `mesh` to a finished tree in the nodes and primitive_ids of `memory`, and waits for it. Every device
/// builder is this chain of stages; `algorithm` is its cluster stage, and optimisers are at its end.
[[nodiscard]] BuildStats run_pipeline(Session& session, const DeviceAlgorithm& algorithm, const BuildSettings& settings,
                                      const ProgressCallback& progress, const DeviceMesh& mesh, OwnMemory& memory,
                                      PipelineEnd& end);

}  // namespace clbvh::device
