#include "device/build/pipeline.hpp"

#include <span>
#include <utility>
#include <vector>

#include "device/build/bounds.hpp"
#include "device/build/leaves.hpp"
#include "device/build/morton.hpp"
#include "device/build/radix_sort.hpp"
#include "device/build/recode.hpp"
#include "device/build/root.hpp"
#include "device/opencl/lane_shape_check.hpp"

namespace clbvh::device {
namespace {

/// Those of the stages, and the algorithm's own.
struct PipelinePrograms {
    std::vector<ProgramSpec> stages;
    ProgramSpec own;
};

PipelinePrograms programs_of(const Session& session, const DeviceAlgorithm& algorithm, const BuildSettings& settings) {
    std::vector<ProgramSpec> stages{bounds_program(settings), morton_program(settings), radix_sort_program(settings),
                                    root_program(settings)};
    if (session.joins_programs() || settings.recodes()) stages.push_back(recode_program(settings));
    // Where the stages' files are one program, it is the same for all builders: drivers that cache it know its text.
    if (session.joins_programs() || algorithm.box_order == BoxOrder::morton) {
        stages.push_back(leaves_program(settings));
    }
    if (session.joins_programs() && (settings.lane() || settings.sort_shape == Shape::lane)) {
        stages.push_back(lane_shape_check_program());
    }
    return {std::move(stages), algorithm.program(settings)};
}

void prepare_programs(Session& session, const DeviceAlgorithm& algorithm, const BuildSettings& settings) {
    const PipelinePrograms programs = programs_of(session, algorithm, settings);
    session.prepare({programs.stages, std::span(&programs.own, 1)});
}

void launch_stages(Launcher& launcher, const DeviceAlgorithm& algorithm, const BuildSettings& settings,
                   const DeviceMesh& mesh, const BuildBuffers& buffers, bool asynchronous,
                   host::TopMemory* top_memory) {
    launcher.begin_stage("bounds", 0.0);
    launch_bounds(launcher, settings, buffers, mesh);
    launcher.begin_stage("morton", 0.05);
    launch_morton(launcher, settings, buffers, mesh.primitive_count);
    launcher.begin_stage("sort", 0.1);
    launch_radix_sort(launcher, settings, buffers, mesh.primitive_count);
    if (settings.recodes()) launch_recode(launcher, settings, buffers, mesh.primitive_count);
    launcher.begin_stage("cluster", 0.3);
    if (algorithm.box_order == BoxOrder::morton) {
        launch_leaves(launcher, settings, buffers, mesh.active_count);
    }
    with_opencl_errors("clustering", [&] {
        algorithm.cluster({launcher, settings, buffers, mesh.active_count, asynchronous, top_memory});
    });
    launcher.begin_stage("root", 0.95);
    launch_root(launcher, settings, buffers, algorithm.box_order);
}

}  // namespace

std::vector<ProgramSpec> pipeline_programs(const Session& session, const DeviceAlgorithm& algorithm,
                                           const BuildSettings& settings) {
    PipelinePrograms programs = programs_of(session, algorithm, settings);
    programs.stages.push_back(std::move(programs.own));
    return std::move(programs.stages);
}

BuildSettings prepare_pipeline(Session& session, const DeviceAlgorithm& algorithm,
                               const DeviceBuilderConfigs& configs) {
    if (session.joins_programs() && session.may_prefer_lane_shape()) {
        // The kernel that tests the lane shape is built with those that are wanted if it passes.
        DeviceBuilderConfigs lane = configs;
        for (Shape* const shape : {&lane.device.shape, &lane.device.sort_shape}) {
            if (*shape == Shape::automatic) *shape = Shape::lane;
        }
        prepare_programs(session, algorithm, resolve_settings(algorithm, lane, session));
    }
    const BuildSettings settings = resolve_settings(algorithm, configs, session);
    prepare_programs(session, algorithm, settings);
    return settings;
}

MemoryPlan plan_pipeline(const DeviceAlgorithm& algorithm, const BuildSettings& settings, std::uint32_t primitives) {
    return plan_memory(settings, algorithm.box_order, primitives, algorithm.extra_bytes(settings, primitives));
}

void enqueue_pipeline(Launcher& launcher, const DeviceAlgorithm& algorithm, const BuildSettings& settings,
                      const DeviceMesh& mesh, const BuildBuffers& buffers) {
    launch_stages(launcher, algorithm, settings, mesh, buffers, true, nullptr);
    if (settings.groups_primitives()) launch_clear_unused(launcher, settings, buffers);
}

BuildStats run_pipeline(Session& session, const DeviceAlgorithm& algorithm, const BuildSettings& settings,
                        const ProgressCallback& progress, const DeviceMesh& mesh, OwnMemory& memory,
                        const OptimizerChain& optimizers) {
    const MemoryPlan plan = plan_pipeline(algorithm, settings, mesh.primitive_count);
    const std::uint64_t scratch_bytes = optimizers.scratch_bytes(2 * mesh.active_count);
    Block scratch;
    if (mesh.active_count > 0) {
        memory.reserve(session, plan);
        with_opencl_errors("memory for optimizing", [&] {
            if (scratch_bytes > 0) scratch = memory.reserve_tree_scratch(session, scratch_bytes);
        });
    }
    Launcher launcher(session, progress);
    if (mesh.active_count > 0) {
        const BuildBuffers& buffers = memory.buffers();
        launch_stages(launcher, algorithm, settings, mesh, buffers, false,
                      algorithm.uses_host ? &memory.top() : nullptr);
        with_opencl_errors("optimizing", [&] {
            const TreeNodes tree{buffers.nodes, 2 * mesh.active_count, {buffers.leaf_count}};
            optimizers.launch(launcher, tree, scratch, 0.95);
        });
    }
    BuildStats stats = launcher.finish();
    stats.peak_device_bytes = mesh.active_count > 0 ? plan.bytes() + scratch_bytes : 0;
    stats.inactive_primitives = mesh.primitive_count - mesh.active_count;
    return stats;
}

}  // namespace clbvh::device
