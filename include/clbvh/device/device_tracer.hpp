#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"
#include "clbvh/core/ray.hpp"
#include "clbvh/device/context.hpp"
#include "clbvh/device/memory.hpp"
#include "clbvh/device/tracer_options.hpp"
#include "clbvh/export.h"
#include "clbvh/layout/layout_kind.hpp"

namespace clbvh {

/// The tree and the triangles that rays are traced through.
struct DeviceScene {
    /// Nodes at an offset that is a multiple of 64, primitive ids at a multiple of 4. The active count is looked at
    /// where a layout is made.
    DeviceBvh bvh;
    DeviceTriangles triangles;  ///< The mesh that the tree was built over; rays do not look at it where there is a
    DeviceSpan layout;          ///< layout: filled by enqueue_layout of any DeviceTracer for this tree, with the same
                                ///< counts; offset, a multiple of 64. See docs/trace-device.md for how one that is
                                ///< older than its tree is noticed.
    LayoutKind layout_kind = LayoutKind::wide8;  ///< Rays go through wide8 alone. The others are for kernels of the
                                                 ///< caller's; skip and pair do not look at the mesh.
};

/// Where the parts of a layout in device memory are. See docs/layouts.md.
struct DeviceLayout {
    DeviceSpan header;    ///< Three uints: the numbers of nodes and of elements, the depth; all 0 for a tree without
                          ///< leaves.
    DeviceSpan nodes;     ///< WideNode<8>, WideNode<4>, Compressed8Node, SkipNode or PairNode [nodes]
    DeviceSpan elements;  ///< TriangleBlock [elements] of wide8 and wide4, Compressed8Triangle [elements], else uint
                          ///< [elements], the primitive ids.
};

/// Rays that can be traced at once.
inline constexpr std::uint32_t kMaxDeviceRays = 0x7FFFFFFFU;

/// Rays in device memory, and where their hits go.
struct DeviceRays {
    std::uint32_t count = 0;  ///< At most kMaxDeviceRays.
    DeviceSpan rays;          ///< Ray [count]; offset, a multiple of 16.
    DeviceSpan results;       ///< Hit [count], offset a multiple of 16; or, of enqueue_any, a byte each: 1 or 0.
    DeviceSpan counts;        ///< RayCounts [count], offset a multiple of 16; may be left out.
    DeviceSpan scratch;       ///< DeviceTraceSizes::scratch bytes; offset, a multiple of 64.
};

/// Bytes that tracing needs beside the tree, the rays and the hits.
struct DeviceTraceSizes {
    std::uint64_t scratch = 0;  ///< For any number of rays; free again when they are traced.
    /// Some 267 for each reference of a wide8, 233 of a wide4 and 127 of a compressed8, which any tree has room in;
    /// most trees leave half of them as they were. 112 and 176 of skip and pair where leaves have one primitive.
    std::uint64_t layout = 0;
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

    /// Bytes that a tree needs; only the two counts of `bvh` are looked at.
    [[nodiscard]] DeviceTraceSizes sizes(const DeviceBvh& bvh, LayoutKind kind = LayoutKind::wide8) const noexcept;

    /// Where the parts of scene.layout are. Only it, its kind and the two counts of the tree are looked at. Empty spans
    /// for what is no kind.
    [[nodiscard]] static DeviceLayout layout_of(const DeviceScene& scene) noexcept;

    /// Enqueues that scene.layout is filled with the scene as scene.layout_kind says. wide8 is how rays go through it
    /// fastest: worth its time where many rays follow, see docs/trace-device.md. The mesh is not needed afterwards;
    /// the tree still is for wide8. Nodes and elements have the bytes of make_layout() for a Bvh of as many nodes: 2 *
    /// the active count where there is one, else node_count; with more blocks or triangles than make_layout() takes,
    /// the header's numbers are 0. Where one of the tree's counts is 0 there is nothing to lay out, and nothing is
    /// written, no header either. The first call for wide4, and for compressed8, builds a program, which takes a
    /// moment. Throws Error(invalid_input) for what is no kind.
    ///
    /// This and the next two allocate nothing and wait for nothing: they begin when the events in `wait_list` are
    /// complete, in an in-order queue also behind what was enqueued before, and `event`, where given, becomes the
    /// caller's own event of their end. So a build and its rays can follow each other on one queue. All memory is
    /// looked at as DeviceBuilder::enqueue does, and so is what was found wrong thrown. The values cannot be checked:
    /// for a tree with loops, and for numbers out of range in it or in the mesh, the behaviour is undefined.
    void enqueue_layout(cl_command_queue queue, const DeviceScene& scene, EventList wait_list = {},
                        cl_event* event = nullptr);

    /// Enqueues the closest hit of each ray. Invalid rays (see Ray) hit nothing, and so does every ray where the
    /// tree has no leaves. The order of the rays does not matter to the hits, only to the time.
    void enqueue_closest(cl_command_queue queue, const DeviceScene& scene, const DeviceRays& rays,
                         EventList wait_list = {}, cl_event* event = nullptr);

    /// Enqueues, for each ray, whether there is a hit at all.
    void enqueue_any(cl_command_queue queue, const DeviceScene& scene, const DeviceRays& rays, EventList wait_list = {},
                     cl_event* event = nullptr);

    /// Copies a tree and its triangles to the device, for the calls below; tree and mesh may go. Throws
    /// Error(invalid_input) where the tree was not built over this mesh: nodes, ids or indices out of range, or loops;
    /// Error(unsupported) where the device cannot allocate as much at once; Error(out_of_memory). After an Error there
    /// is no scene.
    void set_scene(const Bvh& bvh, const MeshView& mesh);

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
