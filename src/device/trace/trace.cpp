#include "device/trace/trace.hpp"

#include <algorithm>
#include <string>
#include <tuple>

#include "clbvh/core/error.hpp"
#include "core/check_field.hpp"

namespace clbvh::device {
namespace {

constexpr std::uint32_t kGroupSize = 64;
constexpr std::uint32_t kLaneBlock = 64;
constexpr std::uint32_t kStackEntries = 48;

// Memory for deep stacks grows up to here, then only one work item is left and its stack grows with the tree.
constexpr std::uint64_t kDeepBytes = std::uint64_t{16} << 20;
constexpr std::uint64_t kMostDeepItems = 64;

// Subtrees that the lane shape widens each by itself, and the work items for them.
constexpr std::uint32_t kWideSubtrees = 512;

constexpr std::uint32_t kLeafOrder = 5;  // INPUT_LEAF_ORDER of kernels/trace/leaf_triangle.clh

std::uint32_t chosen(std::uint32_t option, std::uint32_t automatic) {
    return option != 0 ? option : automatic;
}

void check_trace_options(const DeviceTracerOptions& options) {
    if (options.work_group_size != 0) check_range("work_group_size", options.work_group_size, 2, 1024);
    check_range("block_rays", options.block_rays, 0, 65536);
    check_range("stack_entries", options.stack_entries, 0, 1024);
    check_range("persistent_groups", options.persistent_groups, 0, 65536);
}

Shape chosen_shape(Session& session, Shape option) {
    if (option != Shape::automatic) return option;
    return session.prefers_lane_shape() ? Shape::lane : Shape::group;
}

cl_device_fp_config float_abilities(const Session& session) {
    return session.queue().getInfo<CL_QUEUE_DEVICE>().getInfo<CL_DEVICE_SINGLE_FP_CONFIG>();
}

// SCENE_ARGUMENTS of kernels/trace/trace.cl. What a scene lacks is not read, but no kernel is given a null buffer.
auto scene_arguments(const TraceScene& scene, const cl::Buffer& stand_in) {
    const auto given = [&](const cl::Buffer& buffer) { return buffer() != nullptr ? buffer : stand_in; };
    const bool has_copy = scene.copy.buffer() != nullptr;
    const DeviceMesh& mesh = scene.mesh;
    return std::make_tuple(given(scene.nodes.buffer), scene.nodes.offset, scene.node_count,
                           given(scene.primitive_ids.buffer), scene.primitive_ids.offset,
                           has_copy ? kLeafOrder : static_cast<std::uint32_t>(mesh.form), given(mesh.vertices),
                           mesh.vertex_offset, mesh.vertex_stride, given(mesh.triangles), mesh.triangle_offset,
                           mesh.triangle_stride, given(scene.copy.buffer), scene.copy.offset);
}

// RAY_ARGUMENTS of kernels/trace/trace.cl.
auto ray_arguments(const TraceRays& rays) {
    const bool has_counts = rays.counts.buffer() != nullptr;
    return std::make_tuple(rays.rays.buffer, rays.rays.offset, rays.count, rays.results.buffer, rays.results.offset,
                           has_counts ? rays.counts.buffer : rays.scratch.buffer, rays.counts.offset,
                           std::uint32_t{has_counts}, rays.scratch.buffer, rays.scratch.offset);
}

// WIDE_ARGUMENTS of kernels/trace/trace.cl.
auto wide_arguments(const CopyPlan& plan, const Block& copy) {
    return std::make_tuple(copy.buffer, copy.offset + plan.header_offset(), copy.offset + plan.nodes_offset(),
                           copy.offset + plan.blocks_offset());
}

template <typename Arguments>
void launch_with(Launcher& launcher, Kernel& kernel, std::size_t groups, const Arguments& arguments) {
    std::apply([&](const auto&... values) { launcher.launch(kernel, groups, values...); }, arguments);
}

std::size_t groups_for(std::uint64_t count, std::uint32_t each) {
    return static_cast<std::size_t>((count + each - 1) / each);
}

}  // namespace

TraceSettings resolve_trace_settings(Session& session, const DeviceTracerOptions& options) {
    check_trace_options(options);
    TraceSettings settings;
    settings.triangle_test = options.triangle_test;
    settings.shape = chosen_shape(session, options.shape);
    const bool is_group = settings.shape == Shape::group;
    const std::size_t largest = session.info().max_work_group_size;
    if (is_group && options.work_group_size > largest) {
        throw Error(ErrorCode::unsupported, "work_group_size " + std::to_string(options.work_group_size) +
                                                " is too large for " + session.info().name + ", which runs " +
                                                std::to_string(largest));
    }
    const auto group_size = static_cast<std::uint32_t>(std::min<std::size_t>(kGroupSize, largest));
    settings.work_group_size = is_group ? chosen(options.work_group_size, group_size) : 1;
    settings.block_rays = chosen(options.block_rays, is_group ? settings.work_group_size : kLaneBlock);
    settings.stack_entries = chosen(options.stack_entries, kStackEntries);
    settings.persistent_groups = options.persistent_groups;
    const cl_device_fp_config abilities = float_abilities(session);
    settings.rounds_divisions = (abilities & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
    settings.keeps_denormals = (abilities & CL_FP_DENORM) != 0;
    return settings;
}

ProgramSpec trace_program(const TraceSettings& settings) {
    const bool is_watertight = settings.triangle_test == TriangleTest::watertight;
    return {"trace.cl", settings.work_group_size,
            std::string(settings.rounds_divisions ? " -cl-fp32-correctly-rounded-divide-sqrt" : "") +
                " -D TRIANGLE_TEST=" + (is_watertight ? "0" : "1") + " -D BLOCK_RAYS=" +
                std::to_string(settings.block_rays) + " -D TRACE_STACK=" + std::to_string(settings.stack_entries) +
                " -D TRACE_PERSISTENT=" + (settings.persistent_groups > 0 ? "1" : "0")};
}

TracePlan plan_trace(std::uint32_t node_count) {
    TracePlan plan;
    plan.deep_capacity = node_count / 2 + 1;
    const std::uint64_t affordable = kDeepBytes / (TracePlan::kEntryBytes * plan.deep_capacity);
    plan.deep_items = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(affordable, 1, kMostDeepItems));
    return plan;
}

CopyPlan plan_copy(const TraceSettings& settings, std::uint32_t reference_count) {
    CopyPlan plan;
    plan.rows_bytes = CopyPlan::kRowsBytes * reference_count;
    plan.is_wide = settings.shape == Shape::lane && settings.persistent_groups == 0;
    if (plan.is_wide) {
        // Trees of scanned and of modelled scenes take some 0.1 nodes and 0.3 blocks a reference.
        plan.node_capacity = reference_count / 6 + 64;
        plan.block_capacity = reference_count / 2 + 64;
    }
    return plan;
}

void launch_copy(Launcher& launcher, const TraceSettings& settings, const TraceScene& scene, const Block& copy) {
    if (scene.reference_count == 0) return;
    launcher.begin_stage("copy", 0.0);
    const ProgramSpec program = trace_program(settings);
    const auto kernel = [&](const char* name) -> Kernel& { return launcher.session().kernel(program, name); };
    launch_with(
        launcher, kernel("leaf_triangles"), groups_for(scene.reference_count, settings.block_rays),
        std::tuple_cat(scene_arguments(scene, copy.buffer),
                       std::make_tuple(scene.mesh.primitive_count, scene.reference_count, copy.buffer, copy.offset)));
    const CopyPlan plan = plan_copy(settings, scene.reference_count);
    if (!plan.is_wide) return;
    TraceScene copied = scene;
    copied.copy = copy;
    const auto arguments = std::tuple_cat(scene_arguments(copied, copy.buffer), wide_arguments(plan, copy),
                                          std::make_tuple(plan.node_capacity, plan.block_capacity));
    launch_with(launcher, kernel("widen_top"), 1, std::tuple_cat(arguments, std::make_tuple(kWideSubtrees / 2)));
    launch_with(launcher, kernel("widen_rest"), kWideSubtrees, arguments);
}

void launch_trace(Launcher& launcher, const TraceSettings& settings, const TraceScene& scene, const TraceRays& rays) {
    if (rays.count == 0) return;
    launcher.begin_stage("trace", 0.0);
    const ProgramSpec program = trace_program(settings);
    const auto kernel = [&](const char* name) -> Kernel& { return launcher.session().kernel(program, name); };
    const TracePlan plan = plan_trace(scene.node_count);
    const CopyPlan copy = plan_copy(settings, scene.reference_count);
    const auto ray_values = ray_arguments(rays);
    const auto all_values = std::tuple_cat(scene_arguments(scene, rays.scratch.buffer), ray_values);
    const std::size_t blocks = groups_for(rays.count, settings.block_rays);
    const bool is_counted = rays.counts.buffer() != nullptr;
    if (copy.is_wide && scene.copy.buffer() != nullptr && !is_counted) {
        const auto wide_values = wide_arguments(copy, scene.copy);
        launch_with(launcher, kernel("begin_wide_trace"), 1,
                    std::tuple_cat(std::make_tuple(rays.scratch.buffer, rays.scratch.offset), wide_values));
        launch_with(launcher, kernel(rays.any ? "wide_any" : "wide_closest"), blocks,
                    std::tuple_cat(wide_values, ray_values));
    } else {
        launcher.launch(kernel("begin_trace"), 1, rays.scratch.buffer, rays.scratch.offset);
    }
    launch_with(launcher, kernel(rays.any ? "trace_any" : "trace_closest"),
                settings.persistent_groups > 0 ? settings.persistent_groups : blocks, all_values);
    launch_with(
        launcher, kernel(rays.any ? "deep_any" : "deep_closest"), groups_for(plan.deep_items, settings.work_group_size),
        std::tuple_cat(all_values, std::make_tuple(rays.scratch.buffer, rays.scratch.offset + TracePlan::kControlBytes,
                                                   plan.deep_items, plan.deep_capacity)));
}

}  // namespace clbvh::device
