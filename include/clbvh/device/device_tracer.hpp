#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"
#include "clbvh/core/ray.hpp"
#include "clbvh/device/device_builder.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// How a DeviceTracer traces. None of it changes a hit but the triangle test.
struct DeviceTracerOptions {
    TriangleTest triangle_test = TriangleTest::watertight;
    /// group: a work item for each ray. lane: work groups of one item, which takes a block of rays. automatic: lane on
    /// CPUs that pass the self-test.
    Shape shape = Shape::automatic;
    std::uint32_t work_group_size = 0;  ///< Of the group shape, 2 to 1024; 0: 64.
    std::uint32_t block_rays = 0;       ///< Rays for a work group, up to 65536; 0: 64 (lane), or one an item (group).
    std::uint32_t stack_entries = 0;    ///< Of a ray's private stack, 1 to 1024; 0: 48. Rays that need more cost more.
    /// Work groups whose items take rays from a common counter until none is left (Aila, Laine 2009, "Understanding the
    /// Efficiency of Ray Traversal on GPUs", section 3.3), up to 65536; 0: as many groups as there are blocks of rays.
    std::uint32_t persistent_groups = 0;
};

/// A tree in device memory.
struct DeviceBvh {
    DeviceSpan nodes;                   ///< Node [node_count], see Bvh::nodes; a multiple of 64 bytes in.
    std::uint32_t node_count = 0;       ///< Or more, where the number of nodes in use is only known on the device.
    DeviceSpan primitive_ids;           ///< uint [reference_count], see Bvh::primitive_ids; a multiple of 4 bytes in.
    std::uint32_t reference_count = 0;  ///< Or more; what lies behind the tree's own is not used.

    /// What DeviceBuilder::enqueue builds over `primitive_count` primitives, also where some are inactive.
    [[nodiscard]] static DeviceBvh of(const DeviceResult& result, std::uint32_t primitive_count) {
        return {result.nodes, 2 * primitive_count, result.primitive_ids, primitive_count};
    }
};

/// What rays are traced through.
struct DeviceScene {
    DeviceBvh bvh;
    DeviceTriangles triangles;  ///< The mesh that the tree is over; not looked at by rays where there is a copy:
    DeviceSpan copy;  ///< Filled by enqueue_copy of a DeviceTracer with the same options; a multiple of 64 bytes in.
};

/// Rays that can be traced at once.
inline constexpr std::uint32_t kMaxDeviceRays = 0x7FFFFFFFU;

/// Rays in device memory, and where their hits go.
struct DeviceRays {
    std::uint32_t count = 0;  ///< At most kMaxDeviceRays.
    DeviceSpan rays;          ///< Ray [count]; a multiple of 16 bytes in.
    DeviceSpan results;       ///< Hit [count], a multiple of 16 bytes in; or, of enqueue_any, a byte each: 1 or 0.
    DeviceSpan counts;        ///< RayCounts [count], a multiple of 16 bytes in; may be left out.
    DeviceSpan scratch;       ///< DeviceTraceSizes::scratch bytes, a multiple of 64 in.
};

/// Bytes that tracing needs beside the tree, the rays and the hits.
struct DeviceTraceSizes {
    std::uint64_t scratch = 0;  ///< For any number of rays; free again when they are traced.
    std::uint64_t copy = 0;     ///< 48 for each reference in the group shape, some 166 in the lane shape.
};

/// Traces rays on an OpenCL device: from buffers of the caller's into buffers of the caller's, on a queue of the
/// caller's, or from host memory into host memory. Where is_exact() the hits are Tracer's, bit for bit, and so are the
/// counts; see docs/trace-device.md for other devices.
///
///     clbvh::DeviceTracer tracer(context);
///     tracer.set_scene(bvh, mesh);
///     tracer.closest(rays, hits);
///
/// Programs are built when the tracer is made. One thread at a time for all that shares the Context.
class CLBVH_API DeviceTracer {
public:
    /// Throws Error(invalid_input) for options out of range, Error(unsupported) for a work group that the device cannot
    /// run, and what the device says where a program does not build.
    explicit DeviceTracer(Context context, const DeviceTracerOptions& options = {});
    DeviceTracer(const DeviceTracer&) = delete;
    DeviceTracer(DeviceTracer&&) noexcept;
    DeviceTracer& operator=(const DeviceTracer&) = delete;
    DeviceTracer& operator=(DeviceTracer&&) noexcept;
    ~DeviceTracer();

    /// What a tree needs; only the two counts of `bvh` are looked at.
    [[nodiscard]] DeviceTraceSizes sizes(const DeviceBvh& bvh) const noexcept;

    /// Enqueues a copy of the scene into scene.copy that is laid out for speed: worth its time where many rays follow,
    /// see docs/trace-device.md. The mesh is not needed afterwards, the tree is.
    ///
    /// This and the next two allocate nothing and wait for nothing: they begin when the events in `wait_list` are
    /// complete, in an in-order queue also behind what was enqueued before, and `event`, where given, becomes the
    /// caller's own event of their end. So a build and its rays can follow each other on one queue. All memory is
    /// looked at as DeviceBuilder::enqueue does, and so is what was found wrong thrown. The values cannot be checked:
    /// for a tree with loops, and for numbers out of range in it or in the mesh, the behaviour is undefined.
    void enqueue_copy(cl_command_queue queue, const DeviceScene& scene, std::span<const cl_event> wait_list = {},
                      cl_event* event = nullptr);

    /// Enqueues the closest hit of each ray. Rays that are none (see Ray) hit nothing, and so does every ray where the
    /// tree has no leaves. The order of the rays does not matter to the hits, only to the time.
    void enqueue_closest(cl_command_queue queue, const DeviceScene& scene, const DeviceRays& rays,
                         std::span<const cl_event> wait_list = {}, cl_event* event = nullptr);

    /// Enqueues, for each ray, whether there is a hit at all.
    void enqueue_any(cl_command_queue queue, const DeviceScene& scene, const DeviceRays& rays,
                     std::span<const cl_event> wait_list = {}, cl_event* event = nullptr);

    /// Copies a tree and its triangles to the device, for the calls below; tree and mesh may go. Throws
    /// Error(invalid_input) where the tree is none over the mesh: nodes, ids or indices out of range, or loops;
    /// Error(unsupported) where the device cannot allocate as much at once; Error(out_of_memory). After an Error there
    /// is no scene.
    void set_scene(const Bvh& bvh, const Mesh& mesh);

    /// Copies the rays to the device, and their hits back; waits for them. Device memory for a million rays at most is
    /// kept for the next call. Throws Error(invalid_input) without a scene, and where the spans differ in length;
    /// `counts` may be left empty.
    void closest(std::span<const Ray> rays, std::span<Hit> hits, std::span<RayCounts> counts = {});
    void any(std::span<const Ray> rays, std::span<std::uint8_t> is_hit, std::span<RayCounts> counts = {});

    [[nodiscard]] const DeviceTracerOptions& options() const noexcept;
    [[nodiscard]] const Context& context() const noexcept;
    /// The shape that runs: group or lane.
    [[nodiscard]] Shape shape() const noexcept;
    /// True on devices that promise to round divisions correctly and to keep denormal numbers.
    [[nodiscard]] bool is_exact() const noexcept;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace clbvh
