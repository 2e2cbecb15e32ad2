#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "clbvh/core/bvh.hpp"
#include "clbvh/device/context.hpp"
#include "clbvh/device/memory.hpp"
#include "clbvh/device/optimizer_options.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// Improves trees in device memory, in place, on a queue of the caller's: nothing is allocated, nothing is waited for,
/// and the tree never visits the host. Or trees of the host, by way of the device. Programs are built when the
/// optimiser is made.
///
///     clbvh::DeviceOptimizer optimizer("treelet", context);
///     builder.enqueue(queue, triangles, {scratch}, result);
///     optimizer.enqueue(queue, clbvh::DeviceBvh::of(result, triangles.count), {scratch});
///
/// Every optimiser keeps the leaves and the slots in use, and never raises the SAH cost. The same tree gives the
/// same bytes on every run and in both shapes. DeviceBuilder runs the optimisers of BuildOptions::optimizers itself.
/// One thread at a time for all that shares the Context.
class CLBVH_API DeviceOptimizer {
public:
    /// `ids` are ids of optimizers() with commas between them, run in this order. Throws what check_optimizers throws;
    /// Error(unsupported) naming the first that runs on the host only, or where Shape::lane is asked for and treelets
    /// of 8 leaves need more local memory than the device has (Shape::automatic takes the group shape there);
    /// Error(invalid_input) for options out of range; and what the device says where a program does not build.
    DeviceOptimizer(std::string_view ids, Context context, const DeviceOptimizerOptions& options = {});
    DeviceOptimizer(const DeviceOptimizer&) = delete;
    DeviceOptimizer(DeviceOptimizer&&) noexcept;
    DeviceOptimizer& operator=(const DeviceOptimizer&) = delete;
    DeviceOptimizer& operator=(DeviceOptimizer&&) noexcept;
    ~DeviceOptimizer();

    /// Scratch for a tree of so many nodes, in bytes; free again when the tree is done. Throws Error(unsupported) where
    /// the device cannot allocate as much, or the nodes, at once.
    [[nodiscard]] std::uint64_t scratch_bytes(std::uint32_t node_count) const;

    /// Bytes of which the sum of a buffer's own offset and DeviceSpan::offset must be a multiple, for the nodes and the
    /// scratch. Host memory under them (CL_MEM_USE_HOST_PTR) must be aligned to 64 bytes.
    [[nodiscard]] std::uint64_t alignment() const noexcept;

    /// Enqueues the optimisers; of `tree` only the nodes and the active count are looked at. They begin when the events
    /// in `wait_list` are complete, in an in-order queue also behind what was enqueued before, and `event`, where
    /// given, becomes the caller's own event of their end.
    ///
    /// All memory is looked at as DeviceBuilder::enqueue does, the scratch where it takes any: throws
    /// Error(invalid_input) that names the first thing wrong, before anything is enqueued. The values cannot be
    /// checked: for nodes that form no tree, for slots without a node that are not zero, and for an active count out of
    /// range the behaviour is undefined. A tree without leaves, as DeviceBuilder leaves it where no primitive is
    /// active, stays as it is.
    void enqueue(cl_command_queue queue, const DeviceBvh& tree, const DeviceSpan& scratch, EventList wait_list = {},
                 cl_event* event = nullptr);

    /// Copies the tree to the device, runs the optimisers, and waits for the better tree. Takes every tree that
    /// validate() accepts. Throws Error(invalid_input) where the nodes form no tree, naming the first offender;
    /// Error(unsupported) where the device cannot allocate as much at once; Error(out_of_memory).
    [[nodiscard]] Bvh optimize(Bvh tree);

    [[nodiscard]] const DeviceOptimizerOptions& options() const noexcept;
    [[nodiscard]] const Context& context() const noexcept;
    /// The shape that runs: group or lane.
    [[nodiscard]] Shape shape() const noexcept;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace clbvh
