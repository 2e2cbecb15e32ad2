#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "clbvh/device/context.hpp"
#include "clbvh/device/memory.hpp"
#include "clbvh/device/shape.hpp"
#include "clbvh/export.h"
#include "clbvh/metrics/sah.hpp"

namespace clbvh {

/// How a DeviceRefitter works.
struct DeviceRefitterOptions {
    /// automatic: lane on CPUs that pass the self-test. Both give the same boxes.
    Shape shape = Shape::automatic;
    SahCosts costs;  ///< Of the costs that are written.
};

/// Bytes that refitting needs beside the tree and its primitives.
struct DeviceRefitSizes {
    std::uint64_t order = 0;         ///< For the order of a tree's nodes; kept from frame to frame.
    std::uint64_t scratch = 0;       ///< Free again when the boxes are written.
    std::uint64_t cost_scratch = 0;  ///< For the cost alone.
};

/// The arrays that a refit reads and writes beside the tree.
struct DeviceRefit {
    DeviceInput input;   ///< The primitives that the tree was built over, at new places.
    DeviceSpan order;    ///< Written by DeviceRefitter::enqueue_order; offset, a multiple of alignment().
    DeviceSpan scratch;  ///< DeviceRefitSizes::scratch bytes; offset, a multiple of alignment().
    /// Two floats, offset a multiple of 4: the tree's SAH cost with the boxes that were there, and with the new ones,
    /// as RefitStats; a node with an empty box costs nothing. Compensated sums, always in the same order.
    DeviceSpan sah;
    /// A traversal layout of this tree (DeviceScene::layout) that is refitted, too; may be left out: rays that are to
    /// go through it are then refused until it is made anew. Offset, a multiple of 64.
    DeviceSpan layout = {};
};

/// Gives trees in device memory the boxes that moved primitives ask for, on a queue of the caller's: nothing is
/// allocated, and nothing is waited for.
///
///     clbvh::DeviceRefitter refitter(clbvh::Context::adopt(queue));
///     const auto tree = clbvh::DeviceBvh::of(result, triangles.count);
///     const clbvh::DeviceRefitSizes sizes = refitter.sizes(tree.node_count, triangles.count);
///     refitter.enqueue_order(queue, tree, order);                          // once
///     refitter.enqueue(queue, tree, {triangles, order, scratch, sah});     // for each frame
///
/// The boxes are those of refit(), bit for bit. Programs are built when the refitter is made. One thread at a time for
/// all that shares the Context.
class CLBVH_API DeviceRefitter {
public:
    /// Throws Error(invalid_input) where a cost is negative or not finite, and what the device says where a program
    /// does not build.
    explicit DeviceRefitter(Context context, const DeviceRefitterOptions& options = {});
    DeviceRefitter(const DeviceRefitter&) = delete;
    DeviceRefitter(DeviceRefitter&&) noexcept;
    DeviceRefitter& operator=(const DeviceRefitter&) = delete;
    DeviceRefitter& operator=(DeviceRefitter&&) noexcept;
    ~DeviceRefitter();

    /// Bytes that a tree of so many nodes (DeviceBvh::node_count) over so many primitives needs.
    [[nodiscard]] DeviceRefitSizes sizes(std::uint32_t node_count, std::uint32_t primitive_count) const noexcept;

    /// Bytes at a multiple of which nodes, ids, order and scratch must begin, as DeviceBuilder::alignment().
    [[nodiscard]] std::uint64_t alignment() const noexcept;

    /// Enqueues that `order` is filled with what refits need to know of the tree's structure. It stays true until the
    /// nodes are numbered or linked in another way, as by a new build or by an optimiser.
    ///
    /// Of `tree` this and enqueue_cost() look at the nodes and the active count, enqueue() at all fields.
    ///
    /// This and the next two begin when the events in `wait_list` are complete, in an in-order queue also behind what
    /// was enqueued before, and `event`, where given, becomes the caller's own event of their end. All memory is looked
    /// at as DeviceBuilder::enqueue does, and so is what was found wrong thrown. The values cannot be checked: for a
    /// tree with loops, and for numbers out of range, the behaviour is undefined.
    void enqueue_order(cl_command_queue queue, const DeviceBvh& tree, const DeviceSpan& order, EventList wait_list = {},
                       cl_event* event = nullptr);

    /// Enqueues that leaves get the boxes of their primitives, and inner nodes those of their children. Where
    /// references were split, leaves get the boxes of whole primitives. A primitive with a NaN coordinate counts for
    /// nothing, whether it had one when the tree was built or not; a leaf with none but such becomes a box that nothing
    /// hits and that costs nothing (lower corner infinity, upper corner minus infinity). A primitive that was inactive
    /// then is in no leaf, and stays out. In the layout, boxes become those of the nodes that they were made of, and
    /// vertices the new ones. Throws Error(invalid_input) where it is none of this tree, or of boxes. Without nodes,
    /// references or primitives nothing is written but two zeros to `sah`.
    void enqueue(cl_command_queue queue, const DeviceBvh& tree, const DeviceRefit& refit, EventList wait_list = {},
                 cl_event* event = nullptr);

    /// Enqueues that the tree's SAH cost, one float, is written to `sah`: one pass over its nodes, no order needed.
    void enqueue_cost(cl_command_queue queue, const DeviceBvh& tree, const DeviceSpan& scratch, const DeviceSpan& sah,
                      EventList wait_list = {}, cl_event* event = nullptr);

    [[nodiscard]] const DeviceRefitterOptions& options() const noexcept;
    [[nodiscard]] const Context& context() const noexcept;
    /// The shape that runs: group or lane.
    [[nodiscard]] Shape shape() const noexcept;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace clbvh
