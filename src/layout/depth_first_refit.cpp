// Refits of layouts in depth-first order, backwards: what is below a node stands behind it, without gaps, so that tasks
// take nodes as they lie, and only those whose children reach over the end of a task's wait until all tasks are done.
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "clbvh/layout/pair.hpp"
#include "clbvh/layout/skip.hpp"
#include "core/merge_primitives.hpp"
#include "core/negative_zero.hpp"
#include "core/simd/box4.hpp"
#include "layout/refit_in_arena.hpp"

namespace clbvh {
namespace {

/// Writes a box where nodes have it, with the words behind its corners as they are.
void store(const Box4& box, float* lower, std::uint32_t behind_lower, float* upper, std::uint32_t behind_upper) {
    box.lower.with_w(behind_lower).store(lower);
    box.upper.with_w(behind_upper).store(upper);
}

Box4 merged(Box4 a, const Box4& b) {
    a.merge(b);
    return a;
}

/// The leaves of a layout, which reads ahead of them. `Reader` is one of merge_primitives.hpp.
template <typename Reader>
class LeafBoxes {
public:
    LeafBoxes(const Reader& primitives, const std::uint32_t* ids) : primitives_(primitives), ids_(ids) {}

    /// Of the primitives whose ids are at `first` and behind it. Leaves come from the last to the first.
    [[nodiscard]] Box4 box(std::uint32_t first, std::uint32_t count) const {
        Box4 box;
        for (std::uint32_t place = first; place < first + count; ++place) {
            if (place >= 2 * kAhead) primitives_.prefetch_of(ids_[place - 2 * kAhead]);
            if (place >= kAhead) primitives_.prefetch_vertices_of(ids_[place - kAhead]);
            primitives_.merge_into(box, ids_[place]);
        }
        return without_negative_zeros(box);
    }

private:
    static constexpr std::uint32_t kAhead = 16;

    Reader primitives_;
    const std::uint32_t* ids_;
};

/// How the nodes of a SkipLayout are read and written.
template <typename Leaves>
class SkipNodes {
public:
    SkipNodes(SkipNode* nodes, const Leaves& leaves) : nodes_(nodes), leaves_(leaves) {}

    [[nodiscard]] bool is_leaf(std::uint32_t i) const noexcept { return nodes_[i].is_leaf(); }
    /// Of an inner node. Reads the node behind it.
    [[nodiscard]] std::uint32_t second_child(std::uint32_t i) const noexcept {
        return nodes_[i + 1].is_leaf() ? i + 2 : nodes_[i + 1].link;
    }
    [[nodiscard]] Box4 fit_leaf(std::uint32_t i) const {
        const Box4 box = leaves_.box(nodes_[i].link, nodes_[i].count);
        write(i, box);
        return box;
    }
    void write_inner(std::uint32_t i, const Box4& first, const Box4& second) const { write(i, merged(first, second)); }
    /// The box of a node that is done.
    [[nodiscard]] Box4 read(std::uint32_t i) const { return Box4::of(nodes_[i]); }

private:
    void write(std::uint32_t i, const Box4& box) const {
        store(box, nodes_[i].lower, nodes_[i].link, nodes_[i].upper, nodes_[i].count);
    }

    SkipNode* nodes_;
    Leaves leaves_;
};

/// How those of a PairLayout are, in which boxes are the parents'.
template <typename Leaves>
class PairNodes {
public:
    PairNodes(PairNode* nodes, const Leaves& leaves) : nodes_(nodes), leaves_(leaves) {}

    [[nodiscard]] bool is_leaf(std::uint32_t i) const noexcept { return nodes_[i].is_leaf(); }
    [[nodiscard]] std::uint32_t second_child(std::uint32_t i) const noexcept { return nodes_[i].right; }
    [[nodiscard]] Box4 fit_leaf(std::uint32_t i) const { return leaves_.box(nodes_[i].first, nodes_[i].count); }
    void write_inner(std::uint32_t i, const Box4& first, const Box4& second) const {
        PairNode& node = nodes_[i];
        store(first, node.left_lower, node.left, node.left_upper, node.right);
        store(second, node.right_lower, node.count, node.right_upper, node.first);
    }
    [[nodiscard]] Box4 read(std::uint32_t i) const {
        const PairNode& node = nodes_[i];
        if (node.is_leaf()) return fit_leaf(i);
        return merged({Float4::load(node.left_lower), Float4::load(node.left_upper)},
                      {Float4::load(node.right_lower), Float4::load(node.right_upper)});
    }

private:
    PairNode* nodes_;
    Leaves leaves_;
};

/// The nodes that one task takes.
constexpr std::uint32_t kNodesOfTask = 2048;

/// Refits nodes begin .. end - 1, but for those with children that are not done, which go to `waiting`.
template <typename Nodes>
void refit_range(const Nodes& nodes, std::uint32_t begin, std::uint32_t end, std::vector<std::uint32_t>& waiting) {
    std::array<Box4, kNodesOfTask> boxes;
    std::array<bool, kNodesOfTask> is_done;
    for (std::uint32_t i = end; i-- > begin;) {
        is_done[i - begin] = true;
        if (nodes.is_leaf(i)) {
            boxes[i - begin] = nodes.fit_leaf(i);
            continue;
        }
        // A first child behind the end is another task's, which may be writing it.
        const std::uint32_t second = i + 1 < end ? nodes.second_child(i) : end;
        if (second >= end || !is_done[second - begin]) {
            is_done[i - begin] = false;
            waiting.push_back(i);
            continue;
        }
        const Box4 &a = boxes[i + 1 - begin], &b = boxes[second - begin];
        nodes.write_inner(i, a, b);
        boxes[i - begin] = merged(a, b);
    }
}

/// In the current arena.
template <typename Nodes>
void refit_all(const Nodes& nodes, std::uint32_t node_count) {
    const std::uint32_t tasks = (node_count + kNodesOfTask - 1) / kNodesOfTask;
    std::vector<std::vector<std::uint32_t>> waiting(tasks);
    tbb::parallel_for(
        std::uint32_t{0}, tasks,
        [&](std::uint32_t task) {
            const std::uint32_t begin = task * kNodesOfTask;
            refit_range(nodes, begin, std::min(begin + kNodesOfTask, node_count), waiting[task]);
        },
        tbb::simple_partitioner{});
    // Only nodes above a task's last one can wait: what is below any other ends in front of it.
    for (std::uint32_t task = tasks; task-- > 0;) {
        for (const std::uint32_t i : waiting[task])
            nodes.write_inner(i, nodes.read(i + 1), nodes.read(nodes.second_child(i)));
    }
}

template <template <typename> typename Nodes, typename Layout>
void run_refit(Layout& layout, const Primitives& primitives, const LayoutOptions& options) {
    layout::refit_in_arena(layout, primitives, options, [&] {
        with_merging(primitives, [&](const auto& reader) {
            using Leaves = LeafBoxes<std::remove_cvref_t<decltype(reader)>>;
            const Nodes<Leaves> nodes(layout.nodes.data(), Leaves(reader, layout.primitive_ids.data()));
            refit_all(nodes, static_cast<std::uint32_t>(layout.nodes.size()));
        });
    });
}

}  // namespace

void refit(SkipLayout& layout, const Primitives& primitives, const LayoutOptions& options) {
    run_refit<SkipNodes>(layout, primitives, options);
}

void refit(PairLayout& layout, const Primitives& primitives, const LayoutOptions& options) {
    run_refit<PairNodes>(layout, primitives, options);
}

}  // namespace clbvh
