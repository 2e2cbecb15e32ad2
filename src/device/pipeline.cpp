#include "device/pipeline.hpp"

#include "device/bounds.hpp"
#include "device/layout.hpp"
#include "device/leaves.hpp"
#include "device/morton.hpp"
#include "device/radix_sort.hpp"

namespace clbvh::device {
namespace {

void launch_stages(Launcher& launcher, const DeviceAlgorithm& algorithm, const BuildSettings& settings,
                   const DeviceMesh& mesh, const BuildBuffers& buffers) {
    launcher.begin_stage("bounds", 0.0);
    launch_bounds(launcher, settings, buffers, mesh);
    launcher.begin_stage("morton", 0.05);
    launch_morton(launcher, settings, buffers, mesh.primitive_count);
    launcher.begin_stage("sort", 0.1);
    launch_radix_sort(launcher, settings, buffers, mesh.primitive_count);
    launcher.begin_stage("cluster", 0.3);
    if (algorithm.box_order == BoxOrder::morton) {
        launch_leaves(launcher, settings, buffers, mesh.active_count);
    }
    with_opencl_errors("clustering", [&] { algorithm.cluster({launcher, settings, buffers, mesh.active_count}); });
    launcher.begin_stage("layout", 0.95);
    launch_layout(launcher, settings, buffers, algorithm.box_order);
}

}  // namespace

BuildStats run_pipeline(Session& session, const DeviceAlgorithm& algorithm, const BuildSettings& settings,
                        const ProgressCallback& progress, const DeviceMesh& mesh, OwnMemory& memory) {
    const MemoryPlan plan = plan_memory(settings, algorithm.box_order, mesh.primitive_count,
                                        algorithm.extra_bytes(settings, mesh.primitive_count));
    if (mesh.active_count > 0) {
        memory.reserve(session, plan);
    }
    Launcher launcher(session, progress);
    if (mesh.active_count > 0) {
        launch_stages(launcher, algorithm, settings, mesh, memory.buffers());
    }
    BuildStats stats = launcher.finish();
    stats.peak_device_bytes = mesh.active_count > 0 ? plan.bytes() : 0;
    stats.inactive_primitives = mesh.primitive_count - mesh.active_count;
    return stats;
}

}  // namespace clbvh::device
