#pragma once

#include "device/build/device_algorithm.hpp"
#include "device/tree/optimize.hpp"

namespace clbvh::device {

/// All programs of a build with these settings.
[[nodiscard]] std::vector<ProgramSpec> pipeline_programs(const Session& session, const DeviceAlgorithm& algorithm,
                                                         const BuildSettings& settings);

/// Resolves the options, and builds the programs that run_pipeline() will use with them. Throws what resolve_settings
/// and Session::prepare throw.
[[nodiscard]] BuildSettings prepare_pipeline(Session& session, const DeviceAlgorithm& algorithm,
                                             const DeviceBuilderConfigs& configs);

/// The memory of a build over `primitives`.
[[nodiscard]] MemoryPlan plan_pipeline(const DeviceAlgorithm& algorithm, const BuildSettings& settings,
                                       std::uint32_t primitives);

/// Enqueues a build of a mesh with at least one primitive, and waits for nothing that the algorithm need not wait for.
void enqueue_pipeline(Launcher& launcher, const DeviceAlgorithm& algorithm, const BuildSettings& settings,
                      const DeviceMesh& mesh, const BuildBuffers& buffers);

/// Builds from `mesh` to a finished tree in the nodes and primitive_ids of `memory`, and waits for it. Every device
/// builder is this chain of stages; `algorithm` is its cluster stage, and `optimizers` are at its end.
[[nodiscard]] BuildStats run_pipeline(Session& session, const DeviceAlgorithm& algorithm, const BuildSettings& settings,
                                      const ProgressCallback& progress, const DeviceMesh& mesh, OwnMemory& memory,
                                      const OptimizerChain& optimizers);

}  // namespace clbvh::device
