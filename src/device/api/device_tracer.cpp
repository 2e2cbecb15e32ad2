#include "clbvh/device/device_tracer.hpp"

#include <optional>
#include <string>
#include <utility>

#include "clbvh/core/error.hpp"
#include "core/memory_errors.hpp"
#include "device/api/caller_input.hpp"
#include "device/trace/host_scene.hpp"
#include "device/trace/trace.hpp"
#include "trace/check_tree.hpp"

namespace clbvh {
namespace {

using device::Block;
using device::CallerMemory;
using device::Session;
using device::TraceRays;
using device::TraceScene;
using device::TraceSettings;

constexpr std::uint64_t kNodeAlignment = 64;  // a sibling pair
constexpr std::uint64_t kRayAlignment = 16;

TraceSettings prepare_tracing(Session& session, const DeviceTracerOptions& options) {
    const TraceSettings settings = device::resolve_trace_settings(session, options);
    const device::ProgramSpec program = device::trace_program(settings);
    session.prepare({std::span(&program, 1)});
    return settings;
}

/// Memory that was looked at and begins where its elements may.
CallerMemory look_at_array(const Session& session, std::string_view name, const DeviceSpan& span, std::uint64_t bytes,
                           std::uint64_t alignment) {
    CallerMemory memory = device::look_at(session, name, span, bytes);
    device::check_aligned(memory, alignment);
    return memory;
}

/// The same, of what kernels read.
CallerMemory look_at_input(const Session& session, std::string_view name, const DeviceSpan& span, std::uint64_t bytes,
                           std::uint64_t alignment) {
    CallerMemory memory = look_at_array(session, name, span, bytes, alignment);
    device::check_readable(memory);
    return memory;
}

Block block_of(const CallerMemory& memory) {
    return {memory.buffer, memory.offset};
}

/// A scene of the caller's, looked at.
struct CheckedScene {
    TraceScene scene;
    CallerMemory nodes, primitive_ids, vertices, indices, copy;

    void check_apart_from(const CallerMemory& written) const {
        for (const CallerMemory& read : {nodes, primitive_ids, vertices, indices, copy})
            device::check_apart({written, read});
    }
};

void check_references(const Session& session, const DeviceScene& given, CheckedScene& checked) {
    device::check_multiple("the primitive ids' offset", given.bvh.primitive_ids.offset, 0, sizeof(cl_uint));
    checked.primitive_ids = device::look_at(session, "the primitive ids", given.bvh.primitive_ids,
                                            sizeof(cl_uint) * std::uint64_t{given.bvh.reference_count});
    device::check_readable(checked.primitive_ids);
    checked.scene.primitive_ids = block_of(checked.primitive_ids);
    device::CallerInput input = device::check_input(session, given.triangles);
    checked.vertices = std::move(input.vertices);
    checked.indices = std::move(input.indices);
    checked.scene.mesh = input.mesh;
}

CallerMemory look_at_copy(const Session& session, const TraceSettings& settings, const DeviceScene& given) {
    return look_at_array(session, "the copy", given.copy,
                         device::plan_copy(settings, given.bvh.reference_count).bytes(), kNodeAlignment);
}

void check_nodes(const Session& session, const DeviceScene& given, CheckedScene& checked) {
    checked.scene.node_count = given.bvh.node_count;
    checked.scene.reference_count = given.bvh.reference_count;
    checked.nodes = look_at_input(session, "the nodes", given.bvh.nodes,
                                  sizeof(Node) * std::uint64_t{given.bvh.node_count}, kNodeAlignment);
    checked.scene.nodes = block_of(checked.nodes);
}

CheckedScene check_scene(const Session& session, const TraceSettings& settings, const DeviceScene& given) {
    CheckedScene checked;
    if (given.bvh.node_count == 0 || given.bvh.reference_count == 0) return checked;
    check_nodes(session, given, checked);
    if (given.copy.buffer == nullptr) {
        check_references(session, given, checked);
    } else {
        checked.copy = look_at_copy(session, settings, given);
        device::check_readable(checked.copy);
        checked.scene.copy = block_of(checked.copy);
    }
    return checked;
}

TraceRays check_rays(const Session& session, const CheckedScene& scene, const DeviceRays& given, bool any) {
    const std::uint64_t count = given.count;
    if (count > kMaxDeviceRays) {
        throw Error(ErrorCode::unsupported, std::to_string(count) + " rays are more than the " +
                                                std::to_string(kMaxDeviceRays) + " of one call; trace in parts");
    }
    const CallerMemory rays = look_at_input(session, "the rays", given.rays, sizeof(Ray) * count, kRayAlignment);
    const CallerMemory results =
        any ? device::look_at(session, "the results", given.results, count)
            : look_at_array(session, "the results", given.results, sizeof(Hit) * count, kRayAlignment);
    const CallerMemory scratch =
        look_at_array(session, "the scratch", given.scratch, device::plan_trace(scene.scene.node_count).scratch_bytes(),
                      kNodeAlignment);
    CallerMemory counts;
    if (given.counts.buffer != nullptr) {
        counts = look_at_array(session, "the counts", given.counts, sizeof(RayCounts) * count, kRayAlignment);
    }
    device::check_apart({results, scratch, counts, rays});
    for (const CallerMemory& written : {results, scratch, counts}) {
        device::check_read_write(written);
        scene.check_apart_from(written);
    }
    TraceRays checked;
    checked.count = given.count;
    checked.any = any;
    checked.rays = block_of(rays);
    checked.results = block_of(results);
    checked.scratch = block_of(scratch);
    checked.counts = block_of(counts);
    return checked;
}

void check_length(std::string_view name, std::size_t length, std::size_t rays) {
    if (length == rays) return;
    throw Error(ErrorCode::invalid_input, std::string(name) + " has room for " + std::to_string(length) +
                                              " rays, but there are " + std::to_string(rays) + "; it must be as many");
}

}  // namespace

struct CLBVH_NO_EXPORT DeviceTracer::State {
    State(Context chosen_context, const DeviceTracerOptions& chosen_options)
        : context(std::move(chosen_context)),
          options(chosen_options),
          settings(prepare_tracing(context.session(), options)) {}

    void enqueue_trace(cl_command_queue queue, const DeviceScene& given, const DeviceRays& rays, bool any,
                       std::span<const cl_event> wait_list, cl_event* event) const {
        device::with_opencl_errors("enqueuing rays", [&] {
            Session& session = context.session();
            device::check_queue(session, queue);
            device::Launcher launcher(session, cl::CommandQueue(queue, true), device::copy_events(wait_list));
            const CheckedScene scene = check_scene(session, settings, given);
            if (rays.count > 0) {
                device::launch_trace(launcher, settings, scene.scene, check_rays(session, scene, rays, any));
            }
            launcher.hand_over_end(event);
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

DeviceTraceSizes DeviceTracer::sizes(const DeviceBvh& bvh) const noexcept {
    return {device::plan_trace(bvh.node_count).scratch_bytes(),
            device::plan_copy(state_->settings, bvh.reference_count).bytes()};
}

void DeviceTracer::enqueue_copy(cl_command_queue queue, const DeviceScene& scene, std::span<const cl_event> wait_list,
                                cl_event* event) {
    device::with_opencl_errors("enqueuing a copy of a scene", [&] {
        Session& session = state_->context.session();
        device::check_queue(session, queue);
        device::Launcher launcher(session, cl::CommandQueue(queue, true), device::copy_events(wait_list));
        if (scene.bvh.reference_count > 0 && scene.bvh.node_count > 0) {
            CheckedScene checked;
            check_nodes(session, scene, checked);
            check_references(session, scene, checked);
            const CallerMemory out = look_at_copy(session, state_->settings, scene);
            device::check_read_write(out);
            checked.check_apart_from(out);
            device::launch_copy(launcher, state_->settings, checked.scene, block_of(out));
        }
        launcher.hand_over_end(event);
    });
}

void DeviceTracer::enqueue_closest(cl_command_queue queue, const DeviceScene& scene, const DeviceRays& rays,
                                   std::span<const cl_event> wait_list, cl_event* event) {
    state_->enqueue_trace(queue, scene, rays, false, wait_list, event);
}

void DeviceTracer::enqueue_any(cl_command_queue queue, const DeviceScene& scene, const DeviceRays& rays,
                               std::span<const cl_event> wait_list, cl_event* event) {
    state_->enqueue_trace(queue, scene, rays, true, wait_list, event);
}

void DeviceTracer::set_scene(const Bvh& bvh, const Mesh& mesh) {
    with_memory_errors("a scene's check", [&] {
        state_->host_scene.reset();
        static_cast<void>(trace::check_tree(bvh, mesh));
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
