// Backwards, since a node has a higher number than its parent. Boxes on a grid are larger than what they are around, so
// that the exact boxes of nodes are kept meanwhile. What is below most nodes is near them: tasks take nodes as they
// lie, and those whose children are another task's wait until all tasks are done.
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "clbvh/layout/compressed8.hpp"
#include "core/merge_primitives.hpp"
#include "core/negative_zero.hpp"
#include "layout/compressed8_grid.hpp"
#include "layout/compressed8_triangle.hpp"
#include "layout/refit_in_arena.hpp"

namespace clbvh {
namespace {

using namespace layout;

/// `Triangles` is one of primitive_access.hpp.
template <typename Triangles>
class Compressed8Refit {
public:
    Compressed8Refit(Compressed8& layout, const Triangles& triangles)
        : nodes_(layout.nodes.data()),
          node_count_(layout.nodes.size()),
          written_(layout.triangles.data()),
          triangles_(triangles) {
        boxes_.resize_for_overwrite(node_count_);
    }

    void run() {
        // Enough tasks for many threads, and few enough nodes that wait.
        const std::size_t nodes_of_task = std::max<std::size_t>(4096, node_count_ / 256);
        const std::size_t tasks = (node_count_ + nodes_of_task - 1) / nodes_of_task;
        std::vector<std::vector<std::uint32_t>> waiting(tasks);
        tbb::parallel_for(
            std::size_t{0}, tasks,
            [&](std::size_t task) {
                const std::size_t begin = task * nodes_of_task;
                refit_range(begin, std::min(begin + nodes_of_task, node_count_), waiting[task]);
            },
            tbb::simple_partitioner{});
        for (std::size_t task = tasks; task-- > 0;) {
            for (const std::uint32_t i : waiting[task])
                refit_node(i);
        }
    }

private:
    static constexpr std::size_t kTrianglesAhead = 16;

    void refit_range(std::size_t begin, std::size_t end, std::vector<std::uint32_t>& waiting) {
        std::vector<bool> is_done(end - begin);
        for (std::size_t i = end; i-- > begin;) {
            const std::size_t first = nodes_[i].first_child;
            const std::size_t behind = first + static_cast<std::size_t>(std::popcount(nodes_[i].inner_mask));
            bool can_be_done = behind <= end;
            for (std::size_t child = first; can_be_done && child < behind; ++child)
                can_be_done = is_done[child - begin];
            is_done[i - begin] = can_be_done;
            if (can_be_done) {
                refit_node(i);
            } else {
                waiting.push_back(static_cast<std::uint32_t>(i));
            }
        }
    }

    /// Those of its children are done.
    void refit_node(std::size_t i) {
        Compressed8Node& node = nodes_[i];
        std::array<Node, 8> leaves;
        std::array<const Node*, 8> boxes;
        Box4 all;
        const Node* child = &boxes_[node.inner_mask == 0 ? 0 : node.first_child];
        for (std::uint32_t slot = 0; slot < 8; ++slot) {
            boxes[slot] = nullptr;
            if (node.is_empty(slot)) continue;
            if (node.is_inner(slot)) {
                boxes[slot] = child++;
            } else {
                leaves[slot] = make_node(refit_leaf(node, slot), 0, 0);
                boxes[slot] = &leaves[slot];
            }
            const Box4 box = Box4::of(*boxes[slot]);
            all.merge(box);
            if (!all_at_most(box.lower, box.upper)) boxes[slot] = nullptr;
        }
        boxes_[i] = make_node(all, 0, 0);
        write_boxes(boxes, node);
    }

    /// Triangles and box of one leaf.
    Box4 refit_leaf(const Compressed8Node& node, std::uint32_t slot) {
        const MergeTriangles reader{triangles_};
        const std::size_t first = node.triangle(slot), behind = first + node.triangle_count(slot);
        Box4 box;
        for (std::size_t place = first; place < behind; ++place) {
            if (place >= 2 * kTrianglesAhead) reader.prefetch_of(written_[place - 2 * kTrianglesAhead].primitive);
            if (place >= kTrianglesAhead) reader.prefetch_vertices_of(written_[place - kTrianglesAhead].primitive);
            const std::uint32_t primitive = written_[place].primitive;
            reader.merge_into(box, primitive);
            move_triangle(written_[place], make_triangle(triangles_, primitive));
        }
        return without_negative_zeros(box);
    }

    /// All but the primitive, which other tasks read ahead of their own triangles.
    static void move_triangle(Compressed8Triangle& triangle, const Compressed8Triangle& moved) {
        triangle.edge2 = moved.edge2;
        triangle.edge1 = moved.edge1;
        triangle.vertex0 = moved.vertex0;
    }

    /// Slots with something that has no box, of NaNs alone, get one that no ray meets.
    static void write_boxes(const std::array<const Node*, 8>& boxes, Compressed8Node& node) {
        static constexpr Node kPoint{{0, 0, 0}, 0, {0, 0, 0}, 0};
        const bool is_any = std::ranges::any_of(boxes, [](const Node* box) { return box != nullptr; });
        write_grid(is_any ? boxes : std::array<const Node*, 8>{&kPoint}, node);
        for (std::uint32_t slot = 0; slot < 8; ++slot) {
            if (boxes[slot] != nullptr || node.is_empty(slot)) continue;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                node.lower[axis][slot] = 0xFF;
                node.upper[axis][slot] = 0;
            }
        }
    }

    Compressed8Node* nodes_;
    std::size_t node_count_;
    Compressed8Triangle* written_;
    Triangles triangles_;
    LayoutArray<Node> boxes_;  ///< The exact one of each node.
};

}  // namespace

void refit(Compressed8& layout, const MeshView& mesh, const LayoutOptions& options) {
    refit_in_arena(layout, mesh, options, [&] {
        with_triangles(mesh, [&](const auto& triangles) { Compressed8Refit(layout, triangles).run(); });
    });
}

}  // namespace clbvh
