#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "clbvh/core/bvh.hpp"
#include "clbvh/layout/make_layout.hpp"
#include "layout/depth_first.hpp"
#include "layout/make_in_arena.hpp"
#include "layout/reject_tree.hpp"

// What layouts share that have one node for each of the binary tree's, in depth-first order.
namespace clbvh::layout {

/// Writes leaves' primitive ids, from all tasks.
class IdWriter {
public:
    IdWriter(const Bvh& bvh, std::uint32_t* result) : bvh_(bvh), result_(result) {}

    /// Those of `leaf`, to place `first`.
    void write(const Node& leaf, std::uint32_t first) {
        std::uint32_t largest = 0;
        for (std::uint32_t i = 0; i < leaf.count; ++i) {
            const std::uint32_t id = bvh_.primitive_ids[std::size_t{leaf.first} + i];
            largest = std::max(largest, id);
            result_[first + i] = id;
        }
        if (largest >= bvh_.primitive_count) has_fault_.store(true, std::memory_order_relaxed);
    }

    /// Some id was none of a primitive.
    [[nodiscard]] bool has_fault() const noexcept { return has_fault_.load(std::memory_order_relaxed); }

private:
    const Bvh& bvh_;
    std::uint32_t* result_;
    std::atomic<bool> has_fault_ = false;
};

/// Makes `result` anew. `write_part(part, ids)` writes the part's nodes, and the ids of its leaves.
template <typename Layout, typename WritePart>
void write_depth_first(const Bvh& bvh, Layout& result, const WritePart& write_part) {
    const DepthFirst order(bvh);
    result.nodes.resize_for_overwrite(order.node_count());
    result.primitive_ids.resize_for_overwrite(order.id_count());
    IdWriter ids(bvh, result.primitive_ids.data());
    order.for_each_part([&](const Part& part) { write_part(part, ids); });
    if (ids.has_fault()) reject_tree(bvh);
    result.depth = order.depth();
}

/// The same from outside of an arena; on an error `result` is empty.
template <typename Layout, typename WritePart>
void make_depth_first(const Bvh& bvh, Layout& result, const LayoutOptions& options, const WritePart& write_part) {
    make_in_arena(result, options, [&] {
        if (!bvh.empty()) write_depth_first(bvh, result, write_part);
    });
    result.primitive_count = bvh.primitive_count;
    result.split_references = bvh.split_references;
}

}  // namespace clbvh::layout
