#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "clbvh/catalog.hpp"
#include "clbvh/device/context.hpp"
#include "clbvh/device/memory.hpp"
#include "clbvh/device/opencl_handles.hpp"
#include "clbvh/export.h"
#include "clbvh/options.hpp"

namespace clbvh {

/// Builds trees from buffers of the caller's into buffers of the caller's, on a queue of the caller's: nothing is
/// allocated, and nothing is waited for (`ploc` excepted, see enqueue()). Programs are built when the builder is made.
///
///     clbvh::DeviceBuilder builder("plocpp-two-level", clbvh::Context::adopt(queue));
///     const clbvh::DeviceBuildSizes sizes = builder.sizes(triangles.count);
///     ... buffers of at least these sizes ...
///     builder.enqueue(queue, triangles, {scratch}, {{nodes}, {primitive_ids}});
///
/// The tree is, byte for byte, the one that Builder makes of the same primitives with OptimizeOn::device. One thread at
/// a time for all that shares the Context: kernels are shared, and their arguments are set by each call.
class CLBVH_API DeviceBuilder {
public:
    /// Throws what Builder's constructor throws, and Error(unsupported) for builders and options that are the host's
    /// work (host builders, hlbvh; max_leaf_size, presplit_level, split_quota). BuildOptions::optimizers run on the
    /// device, one after the other behind the build, wherever BuildOptions::optimize_on would have them: throws what
    /// DeviceOptimizer's constructor throws. BuildOptions::progress is never called.
    DeviceBuilder(std::string_view builder_id, Context context, const BuildOptions& options = {});
    DeviceBuilder(const DeviceBuilder&) = delete;
    DeviceBuilder(DeviceBuilder&&) noexcept;
    DeviceBuilder& operator=(const DeviceBuilder&) = delete;
    DeviceBuilder& operator=(DeviceBuilder&&) noexcept;
    ~DeviceBuilder();

    /// Bytes of memory that a build over `primitive_count` primitives needs. Throws Error(unsupported) where there are
    /// more than kMaxPrimitives, or where the device cannot allocate one of the three at once: the message says how
    /// many primitives it can hold.
    [[nodiscard]] DeviceBuildSizes sizes(std::uint64_t primitive_count) const;

    /// Bytes of which the sum of a buffer's own offset and DeviceSpan::offset must be a multiple, for the nodes, the
    /// primitive ids and the scratch. Host memory under them (CL_MEM_USE_HOST_PTR) must be aligned to 64 bytes.
    [[nodiscard]] std::uint64_t alignment() const noexcept;

    /// Enqueues a build that begins when the events in `wait_list` are complete; `event`, where given, becomes the
    /// caller's own event of its end. As with OpenCL's own commands, an in-order queue puts it behind what was enqueued
    /// before; in an out-of-order queue only `wait_list` does, and what needs the tree must wait for `event`. The queue
    /// is not flushed. Any queue of the context's device will do. The memory may be released, but not used, before the
    /// end.
    ///
    /// The values in the input cannot be checked here. A primitive with a NaN coordinate is inactive: it is in no tree.
    /// Indices out of range, and coordinates that are infinite or beyond kMaxCoordinate, are undefined behaviour;
    /// Builder::upload checks both, for meshes of the host. Where no primitive is active the root is a box that nothing
    /// hits; where there are none at all, nothing but the active count is written.
    ///
    /// `ploc` waits for the device several times within the call (see docs/enqueue.md), and so for `wait_list`.
    ///
    /// Throws Error(invalid_input) that names the first thing wrong with the arguments, before anything is enqueued;
    /// after another Error a part of the build may have been, and the memory's contents are undefined.
    void enqueue(cl_command_queue queue, const DeviceInput& input, const DeviceSpan& scratch,
                 const DeviceResult& result, EventList wait_list = {}, cl_event* event = nullptr);

    [[nodiscard]] const BuilderInfo& info() const noexcept;
    [[nodiscard]] const BuildOptions& options() const noexcept;
    [[nodiscard]] const Context& context() const noexcept;
    /// The shape that runs: what DeviceConfig::shape was resolved to, group or lane.
    [[nodiscard]] Shape shape() const noexcept;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace clbvh
