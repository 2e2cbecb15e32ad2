#pragma once

#include "device/build/build_buffers.hpp"
#include "device/opencl/launcher.hpp"

namespace clbvh::device {

/// Most work items that build one tree: enough for a few thousand triangles, and more would need more local memory.
inline constexpr std::size_t kLargestBatchGroup = 256;

/// Bytes of the memory of a batch.
struct BatchPlan {
    std::uint64_t nodes = 0, primitive_ids = 0, active_counts = 0;  ///< the result
    std::uint64_t scratch = 0;
};
[[nodiscard]] BatchPlan plan_batch(std::uint64_t primitives, std::uint64_t trees);

/// The trees of a batch, and where everything is.
struct BatchJob {
    DeviceMesh mesh;
    std::uint32_t tree_count = 0;
    Block ranges;  ///< uint [tree_count * 4], see kernels/build/batch.cl
    Block nodes, primitive_ids, active_counts, scratch;
};

/// The kernels of batches.
[[nodiscard]] ProgramSpec batch_program(const BuildSettings& settings);

/// Builds all trees in one launch. `job` has at least one primitive and one tree.
void launch_batch(Launcher& launcher, const BuildSettings& settings, const BatchPlan& plan, const BatchJob& job);

}  // namespace clbvh::device
