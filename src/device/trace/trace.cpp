#include "device/trace/trace.hpp"

#include <algorithm>
#include <string>

#include "clbvh/core/error.hpp"
#include "core/check_field.hpp"
#include "device/opencl/device_fit.hpp"
#include "kernels/trace/trace_constants.h"

namespace clbvh::device {
namespace {

constexpr std::uint32_t kGroupSize = 64;
constexpr std::uint32_t kLaneBlock = 64;
constexpr std::uint32_t kStackEntries = 48;

// Places in scratch of the caller's begin where a sibling pair, a line of 64 bytes, may.
constexpr std::uint64_t kAlignment = 64;

// Memory for deep stacks grows up to here, then only one work item is left and its stack grows with the tree.
constexpr std::uint64_t kDeepBytes = std::uint64_t{16} << 20;
constexpr std::uint64_t kMostDeepItems = 64;
constexpr std::uint64_t kControlBytes = 64;
constexpr std::uint64_t kEntryBytes = 8;

std::uint32_t chosen(std::uint32_t option, std::uint32_t automatic) {
    return option != 0 ? option : automatic;
}

void check_trace_options(const DeviceTracerOptions& options) {
    if (options.work_group_size != 0) check_range("work_group_size", options.work_group_size, 2, 1024);
    check_range("block_rays", options.block_rays, 0, 65536);
    check_range("stack_entries", options.stack_entries, 0, 1024);
}

cl_device_fp_config float_abilities(const Session& session) {
    return session.queue().getInfo<CL_QUEUE_DEVICE>().getInfo<CL_DEVICE_SINGLE_FP_CONFIG>();
}

kernels::RaysPlace place_of(const TraceRays& rays, const TraceScratch& scratch) {
    return {.rays = rays.rays.offset,
            .results = rays.results.offset,
            .counts = rays.counts.offset,
            .control = scratch.control.offset,
            .ray_count = rays.count,
            .has_counts = rays.counts.is_there() ? 1u : 0u};
}

std::size_t groups_for(std::uint64_t count, std::uint32_t each) {
    return static_cast<std::size_t>((count + each - 1) / each);
}

}  // namespace

TraceSettings resolve_trace_settings(Session& session, const DeviceTracerOptions& options) {
    check_trace_options(options);
    TraceSettings settings;
    settings.triangle_test = options.triangle_test;
    settings.shape = definite_shape(session, options.shape);
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
    settings.layout = resolve_layout_settings(session, settings.shape);
    settings.stack_entries = chosen(options.stack_entries, kStackEntries);
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
                std::to_string(settings.block_rays) + " -D TRACE_STACK=" + std::to_string(settings.stack_entries)};
}

TraceScratch lay_out_trace_scratch(std::uint32_t node_count, const Block& place) {
    TraceScratch scratch;
    scratch.deep_capacity = node_count / 2 + 1;
    const std::uint64_t affordable = kDeepBytes / (kEntryBytes * scratch.deep_capacity);
    scratch.deep_items = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(affordable, 1, kMostDeepItems));
    ArrayLayout layout(place, kAlignment);
    scratch.control = layout.take(kControlBytes);
    scratch.deep = layout.take(kEntryBytes * scratch.deep_items * scratch.deep_capacity);
    scratch.bytes = layout.bytes();
    return scratch;
}

void launch_trace(Launcher& launcher, const TraceSettings& settings, const TraceScene& scene, const TraceRays& rays) {
    if (rays.count == 0) return;
    launcher.begin_stage("trace", 0.0);
    const ProgramSpec program = trace_program(settings);
    const auto kernel = [&](const char* name) -> Kernel& { return launcher.session().kernel(program, name); };
    const TraceScratch scratch = lay_out_trace_scratch(scene.node_count, rays.scratch);
    const WideParts layout = lay_out_wide(WideKind::wide8, scene.node_count, scene.reference_count, scene.layout);
    const bool has_layout = scene.layout.is_there(), has_counts = rays.counts.is_there();
    kernels::ScenePlace place = place_of(scene);
    if (has_layout) place.form = kernels::INPUT_LEAF_ORDER;
    const kernels::LayoutPlace parts = place_of(layout);
    const kernels::RaysPlace of_rays = place_of(rays, scratch);
    // What a scene lacks is not read, but no kernel is given a null buffer.
    const cl::Buffer& control = scratch.control.buffer;
    const auto given = [&](const cl::Buffer& buffer) -> const cl::Buffer& {
        return buffer() != nullptr ? buffer : control;
    };
    const cl::Buffer& counts = given(rays.counts.buffer);
    const auto launch_binary = [&](const char* name, std::size_t groups, const auto&... rest) {
        launcher.launch(kernel(name), groups, given(scene.nodes.buffer), given(scene.primitive_ids.buffer),
                        given(scene.mesh.vertices.buffer), given(scene.mesh.indices.buffer), place,
                        given(scene.layout.buffer), parts, rays.rays.buffer, rays.results.buffer, counts, control,
                        of_rays, rest...);
    };
    const std::size_t blocks = groups_for(rays.count, settings.block_rays);
    if (has_layout && !has_counts) {
        launcher.launch(kernel("begin_wide_trace"), 1, scene.layout.buffer, parts, control, of_rays);
        launcher.launch(kernel(rays.any ? "wide_any" : "wide_closest"), blocks, scene.layout.buffer, parts,
                        rays.rays.buffer, rays.results.buffer, counts, control, of_rays);
    } else {
        launcher.launch(kernel("begin_trace"), 1, control, of_rays);
    }
    launch_binary(rays.any ? "trace_any" : "trace_closest", blocks);
    launch_binary(rays.any ? "deep_any" : "deep_closest", groups_for(scratch.deep_items, settings.work_group_size),
                  scratch.deep.buffer, scratch.deep.offset, scratch.deep_items, scratch.deep_capacity);
}

}  // namespace clbvh::device
