#include "clbvh/device/device_tracer.hpp"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "clbvh/core/error.hpp"
#include "core/check_length.hpp"
#include "core/memory_errors.hpp"
#include "device/api/caller_input.hpp"
#include "device/api/caller_queue.hpp"
#include "device/api/caller_tree.hpp"
#include "device/api/layout_book.hpp"
#include "device/trace/depth_first_layout.hpp"
#include "device/trace/host_scene.hpp"
#include "device/trace/trace.hpp"
#include "layout/check_tree.hpp"

namespace clbvh {
namespace {

using device::CallerMemory;
using device::Launcher;
using device::Session;
using device::TraceRays;
using device::TraceScene;
using device::TraceSettings;

constexpr std::uint64_t kNodeAlignment = 64;  // a sibling pair
constexpr std::uint64_t kRayAlignment = 16;

TraceSettings prepare_tracing(Session& session, const DeviceTracerOptions& options) {
    const TraceSettings settings = device::resolve_trace_settings(session, options);
    const std::array programs{device::trace_program(settings),
                              device::wide_program(settings.layout, device::WideKind::wide8),
                              device::depth_first_program(settings.layout)};
    session.prepare({programs});
    return settings;
}

/// Memory that was looked at and begins where its elements may.
CallerMemory examine_array(const Session& session, std::string_view name, const DeviceSpan& span, std::uint64_t bytes,
                           std::uint64_t alignment) {
    CallerMemory memory = device::examine(session, name, span, bytes);
    device::check_aligned(memory, alignment);
    return memory;
}

/// The same, of what kernels read.
CallerMemory examine_input(const Session& session, std::string_view name, const DeviceSpan& span, std::uint64_t bytes,
                           std::uint64_t alignment) {
    CallerMemory memory = examine_array(session, name, span, bytes, alignment);
    device::check_readable(memory);
    return memory;
}

/// A scene of the caller's, looked at.
struct CheckedScene {
    TraceScene scene;
    CallerMemory nodes, primitive_ids, vertices, indices, layout;

    void check_apart_from(const CallerMemory& written) const {
        for (const CallerMemory& read : {nodes, primitive_ids, vertices, indices, layout})
            device::check_apart({written, read});
    }
};

void check_ids(const Session& session, const DeviceScene& given, CheckedScene& checked) {
    device::check_multiple("the primitive ids' offset", given.bvh.primitive_ids.offset, 0, sizeof(cl_uint));
    checked.primitive_ids = device::examine(session, "the primitive ids", given.bvh.primitive_ids,
                                            sizeof(cl_uint) * std::uint64_t{given.bvh.reference_count});
    device::check_readable(checked.primitive_ids);
    checked.scene.primitive_ids = checked.primitive_ids.given;
}

void check_mesh(const Session& session, const DeviceScene& given, CheckedScene& checked) {
    device::CallerInput input = device::check_input(session, given.triangles);
    checked.vertices = std::move(input.vertices);
    checked.indices = std::move(input.indices);
    checked.scene.mesh = input.mesh;
}

/// The kind's name, or its number where it has none.
std::string name_kind(LayoutKind kind) {
    const std::string_view name = to_string(kind);
    return name.empty() ? std::to_string(static_cast<std::uint32_t>(kind)) : std::string(name);
}

std::optional<device::DepthFirstKind> depth_first_kind(LayoutKind kind) {
    if (kind == LayoutKind::skip) return device::DepthFirstKind::skip;
    if (kind == LayoutKind::pair) return device::DepthFirstKind::pair;
    return std::nullopt;
}

std::optional<device::WideKind> wide_kind(LayoutKind kind) {
    if (kind == LayoutKind::wide8) return device::WideKind::wide8;
    if (kind == LayoutKind::wide4) return device::WideKind::wide4;
    if (kind == LayoutKind::compressed8) return device::WideKind::compressed8;
    return std::nullopt;
}

std::uint64_t layout_bytes(const DeviceBvh& bvh, LayoutKind kind) {
    if (const auto depth_first = depth_first_kind(kind))
        return device::lay_out_depth_first(*depth_first, bvh.node_count, bvh.reference_count).bytes;
    if (const auto wide = wide_kind(kind))
        return device::lay_out_wide(*wide, bvh.node_count, bvh.reference_count).bytes;
    return 0;
}

CallerMemory examine_layout(const Session& session, const DeviceScene& given) {
    return examine_array(session, "the layout", given.layout, layout_bytes(given.bvh, given.layout_kind),
                         kNodeAlignment);
}

void check_nodes(const Session& session, const DeviceScene& given, CheckedScene& checked) {
    checked.scene.node_count = given.bvh.node_count;
    checked.scene.reference_count = given.bvh.reference_count;
    checked.nodes = examine_input(session, "the nodes", given.bvh.nodes,
                                  sizeof(Node) * std::uint64_t{given.bvh.node_count}, kNodeAlignment);
    checked.scene.nodes = checked.nodes.given;
}

CheckedScene check_scene(const Session& session, const DeviceScene& given) {
    CheckedScene checked;
    if (given.bvh.node_count == 0 || given.bvh.reference_count == 0) return checked;
    check_nodes(session, given, checked);
    if (given.layout.buffer == nullptr) {
        check_ids(session, given, checked);
        check_mesh(session, given, checked);
    } else {
        if (given.layout_kind != LayoutKind::wide8) {
            throw Error(ErrorCode::invalid_input,
                        "the layout's kind is " + name_kind(given.layout_kind) + ", and rays go through wide8 alone");
        }
        checked.layout = examine_layout(session, given);
        device::check_readable(checked.layout);
        device::check_layout_of(checked.layout, checked.nodes);
        checked.scene.layout = checked.layout.given;
    }
    return checked;
}

TraceRays check_rays(const Session& session, const CheckedScene& scene, const DeviceRays& given, bool any) {
    const std::uint64_t count = given.count;
    if (count > kMaxDeviceRays) {
        throw Error(ErrorCode::unsupported, std::to_string(count) + " rays are more than the " +
                                                std::to_string(kMaxDeviceRays) + " of one call; trace in parts");
    }
    const CallerMemory rays = examine_input(session, "the rays", given.rays, sizeof(Ray) * count, kRayAlignment);
    const CallerMemory results =
        any ? device::examine(session, "the results", given.results, count)
            : examine_array(session, "the results", given.results, sizeof(Hit) * count, kRayAlignment);
    const CallerMemory scratch =
        examine_array(session, "the scratch", given.scratch,
                      device::lay_out_trace_scratch(scene.scene.node_count).bytes, kNodeAlignment);
    CallerMemory counts;
    if (given.counts.buffer != nullptr) {
        counts = examine_array(session, "the counts", given.counts, sizeof(RayCounts) * count, kRayAlignment);
    }
    device::check_apart({results, scratch, counts, rays});
    for (const CallerMemory& written : {results, scratch, counts}) {
        device::check_read_write(written);
        scene.check_apart_from(written);
        device::note_written(written);
    }
    TraceRays checked;
    checked.count = given.count;
    checked.any = any;
    checked.rays = rays.given;
    checked.results = results.given;
    checked.scratch = scratch.given;
    checked.counts = counts.given;
    return checked;
}

}  // namespace

struct CLBVH_NO_EXPORT DeviceTracer::State {
    State(Context chosen_context, const DeviceTracerOptions& chosen_options)
        : context(std::move(chosen_context)),
          options(chosen_options),
          settings(prepare_tracing(context.session(), options)) {}

    void enqueue_trace(cl_command_queue queue, const DeviceScene& given, const DeviceRays& rays, bool any,
                       EventList wait_list, cl_event* event) const {
        Session& session = context.session();
        device::enqueue_for_caller("enqueuing rays", session, {queue, wait_list, event}, [&](Launcher& launcher) {
            const CheckedScene scene = check_scene(session, given);
            if (rays.count == 0) return;
            device::launch_trace(launcher, settings, scene.scene, check_rays(session, scene, rays, any));
        });
    }

    void trace(std::span<const Ray> rays, bool any, std::span<std::byte> results, std::span<RayCounts> counts) {
        if (!host_scene) throw Error(ErrorCode::invalid_input, "there is no scene to trace; call set_scene first");
        if (!counts.empty()) check_length("counts", counts.size(), rays.size());
        device::with_opencl_errors("tracing rays",
                                   [&] { host_scene->trace(context.session(), settings, rays, any, results, counts); });
    }

    Context context;
    DeviceTracerOptions options;
    TraceSettings settings;
    std::optional<device::HostScene> host_scene;
};

DeviceTracer::DeviceTracer(Context context, const DeviceTracerOptions& options)
    : state_(std::make_unique<State>(std::move(context), options)) {}
DeviceTracer::DeviceTracer(DeviceTracer&&) noexcept = default;
DeviceTracer& DeviceTracer::operator=(DeviceTracer&&) noexcept = default;
DeviceTracer::~DeviceTracer() = default;

DeviceTraceSizes DeviceTracer::sizes(const DeviceBvh& bvh, LayoutKind kind) const noexcept {
    return {device::lay_out_trace_scratch(bvh.node_count).bytes, layout_bytes(bvh, kind)};
}

DeviceLayout DeviceTracer::layout_of(const DeviceScene& scene) noexcept {
    const DeviceBvh& bvh = scene.bvh;
    const auto part = [&](const device::Block& block) {
        return DeviceSpan{scene.layout.buffer, scene.layout.offset + block.offset};
    };
    if (const auto kind = depth_first_kind(scene.layout_kind)) {
        const auto parts = device::lay_out_depth_first(*kind, bvh.node_count, bvh.reference_count);
        return {part(parts.header), part(parts.nodes), part(parts.primitive_ids)};
    }
    if (const auto kind = wide_kind(scene.layout_kind)) {
        const device::WideParts parts = device::lay_out_wide(*kind, bvh.node_count, bvh.reference_count);
        return {part(parts.header), part(parts.nodes), part(parts.blocks)};
    }
    return {};
}

void DeviceTracer::enqueue_layout(cl_command_queue queue, const DeviceScene& scene, EventList wait_list,
                                  cl_event* event) {
    const State& state = *state_;
    Session& session = state.context.session();
    device::enqueue_for_caller("enqueuing a layout", session, {queue, wait_list, event}, [&](Launcher& launcher) {
        const auto wide = wide_kind(scene.layout_kind);
        const auto depth_first = depth_first_kind(scene.layout_kind);
        if (!wide && !depth_first) {
            throw Error(ErrorCode::invalid_input, "there is no layout of kind " + name_kind(scene.layout_kind) +
                                                      "; set layout_kind to one of LayoutKind");
        }
        if (scene.bvh.reference_count == 0 || scene.bvh.node_count == 0) return;
        CheckedScene checked;
        check_nodes(session, scene, checked);
        check_ids(session, scene, checked);
        if (wide) check_mesh(session, scene, checked);
        const CallerMemory active_count = device::examine_active_count(session, scene.bvh.active_count);
        const CallerMemory out = examine_layout(session, scene);
        device::check_read_write(out);
        checked.check_apart_from(out);
        device::check_apart({out, active_count});
        launcher.begin_stage("layout", 0.0);
        checked.scene.active_count = active_count.given;
        checked.scene.layout = out.given;
        if (wide == device::WideKind::wide8) {
            device::note_layout(out, checked.nodes);
        } else {
            device::note_written(out);
        }
        if (wide) device::launch_wide(launcher, state.settings.layout, *wide, checked.scene);
        if (depth_first) device::launch_depth_first(launcher, state.settings.layout, *depth_first, checked.scene);
    });
}

void DeviceTracer::enqueue_closest(cl_command_queue queue, const DeviceScene& scene, const DeviceRays& rays,
                                   EventList wait_list, cl_event* event) {
    state_->enqueue_trace(queue, scene, rays, false, wait_list, event);
}

void DeviceTracer::enqueue_any(cl_command_queue queue, const DeviceScene& scene, const DeviceRays& rays,
                               EventList wait_list, cl_event* event) {
    state_->enqueue_trace(queue, scene, rays, true, wait_list, event);
}

void DeviceTracer::set_scene(const Bvh& bvh, const MeshView& mesh) {
    with_memory_errors("a scene's check", [&] {
        state_->host_scene.reset();
        static_cast<void>(layout::check_tree(bvh, mesh));
        state_->host_scene.emplace(state_->context.session(), state_->settings, bvh, mesh);
    });
}

void DeviceTracer::closest(std::span<const Ray> rays, std::span<Hit> hits, std::span<RayCounts> counts) {
    check_length("hits", hits.size(), rays.size());
    state_->trace(rays, false, std::as_writable_bytes(hits), counts);
}

void DeviceTracer::any(std::span<const Ray> rays, std::span<std::uint8_t> is_hit, std::span<RayCounts> counts) {
    check_length("is_hit", is_hit.size(), rays.size());
    state_->trace(rays, true, std::as_writable_bytes(is_hit), counts);
}

const DeviceTracerOptions& DeviceTracer::options() const noexcept {
    return state_->options;
}
const Context& DeviceTracer::context() const noexcept {
    return state_->context;
}
Shape DeviceTracer::shape() const noexcept {
    return state_->settings.shape;
}
bool DeviceTracer::is_exact() const noexcept {
    return state_->settings.rounds_divisions && state_->settings.keeps_denormals;
}

}  // namespace clbvh
