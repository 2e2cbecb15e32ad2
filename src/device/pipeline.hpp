#pragma once

#include "device/device_algorithm.hpp"

namespace clbvh::device {

/// Builds from `mesh` to a finished tree in the nodes and primitive_ids of `memory`, and waits for it. Every device
/// builder is this chain of stages; `algorithm` is its cluster stage.
[[nodiscard]] BuildStats run_pipeline(Session& session, const DeviceAlgorithm& algorithm, const BuildSettings& settings,
                                      const ProgressCallback& progress, const DeviceMesh& mesh, OwnMemory& memory);

}  // namespace clbvh::device
