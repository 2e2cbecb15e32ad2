#pragma once

#include <tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <new>
#include <span>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "core/scratch.hpp"
#include "core/simd/prefetch.hpp"

namespace clbvh {

/// Visits the inner nodes of a finished tree, children before parents, in parallel. It knows only the tree's nodes, so
/// it has to find them from the root first: a walk lists, in segments of fixed length, the nodes that it meets, and
/// each time that a segment is full it gives the shallowest subtree it has yet to visit to another task. Whoever
/// finishes the last segment below a segment visits that one, backwards. The stack stays flat at any depth.
template <typename Visit>
class BottomUp {
public:
    /// `visit(node)` is called with the index of each inner node. It may run on any thread, for unrelated nodes at
    /// once.
    BottomUp(std::span<const Node> nodes, Scratch& scratch, const Visit& visit)
        : nodes_(nodes),
          visit_(visit),
          segments_(scratch.take<Segment>(most_segments(nodes.size() / 2))),
          order_(scratch.take<std::uint32_t>(segments_.size() * kSegment)) {}

    void run() {
        if (nodes_[0].is_leaf()) return;
        tasks_.run_and_wait([this] { walk(0, kNone); });
    }

private:
    static constexpr std::uint32_t kSegment = 4096;
    static constexpr std::uint32_t kBatch = 32;
    static constexpr std::uint32_t kNone = ~0u;

    struct Segment {
        std::uint32_t above;                 ///< The segment that waits for this one.
        std::uint32_t size;                  ///< Nodes written down.
        std::atomic<std::uint32_t> pending;  ///< Segments it waits for, and itself while it grows.
    };

    /// Each full segment gives at most one subtree away, and each subtree that was given away ends in one more segment.
    static constexpr std::size_t most_segments(std::size_t pairs) { return 2 * (pairs / (kSegment - kBatch)) + 1; }

    /// Writes the inner nodes below and with `root` down, parents before children.
    void walk(std::uint32_t root, std::uint32_t above) {
        std::vector<std::uint32_t> stack{root};
        std::size_t bottom = 0;  // entries below were given away
        std::uint32_t segment = begin_segment(above);
        while (bottom < stack.size()) {
            write_down_batch(stack, bottom, segment);
            if (segments_[segment].size + kBatch <= kSegment || bottom == stack.size()) continue;
            if (stack.size() - bottom > 1) give_away(stack[bottom++], segment);
            const std::uint32_t full = segment;
            segment = begin_segment(full);
            finish(full);
        }
        finish(segment);
    }

    /// Takes some nodes from the stack, and puts their inner children there.
    void write_down_batch(std::vector<std::uint32_t>& stack, std::size_t bottom, std::uint32_t segment) {
        const std::size_t count = std::min<std::size_t>(stack.size() - bottom, kBatch);
        std::uint32_t* const batch = order_.data() + std::size_t{segment} * kSegment + segments_[segment].size;
        segments_[segment].size += static_cast<std::uint32_t>(count);
        std::copy(stack.end() - static_cast<std::ptrdiff_t>(count), stack.end(), batch);
        std::size_t top = stack.size() - count;
        stack.resize(top + 2 * count);
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t left = nodes_[batch[i]].first;
            top = push(left + 1, stack.data(), top);
            top = push(left, stack.data(), top);
        }
        stack.resize(top);
    }

    /// Pushes an inner node, and has its children fetched until it is taken. Leaves and inner nodes come in no order
    /// that could be predicted, so that nothing branches here.
    std::size_t push(std::uint32_t node, std::uint32_t* stack, std::size_t top) const {
        const bool is_inner = !nodes_[node].is_leaf();
        stack[top] = node;
        prefetch(&nodes_[is_inner ? nodes_[node].first : 0]);
        return top + is_inner;
    }

    std::uint32_t begin_segment(std::uint32_t above) {
        if (above != kNone) segments_[above].pending.fetch_add(1, std::memory_order_relaxed);
        const std::uint32_t segment = used_.fetch_add(1, std::memory_order_relaxed);
        new (&segments_[segment]) Segment{above, 0, 1};
        return segment;
    }

    void give_away(std::uint32_t root, std::uint32_t above) {
        segments_[above].pending.fetch_add(1, std::memory_order_relaxed);  // until the walk has begun its own segment
        tasks_.run([this, root, above] {
            walk(root, above);
            finish(above);
        });
    }

    /// Takes one off what `segment` waits for; at 0 it is visited, and the one above it waits for one less.
    void finish(std::uint32_t segment) {
        while (segment != kNone && segments_[segment].pending.fetch_sub(1, std::memory_order_acq_rel) == 1) {
            const std::uint32_t* const begin = order_.data() + std::size_t{segment} * kSegment;
            for (std::uint32_t i = segments_[segment].size; i > 0; --i)
                visit_(begin[i - 1]);
            segment = segments_[segment].above;
        }
    }

    std::span<const Node> nodes_;
    const Visit& visit_;
    std::span<Segment> segments_;
    std::span<std::uint32_t> order_;
    std::atomic<std::uint32_t> used_ = 0;
    tbb::task_group tasks_;
};

}  // namespace clbvh
