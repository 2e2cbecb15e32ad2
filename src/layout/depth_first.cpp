#include "layout/depth_first.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <span>
#include <utility>

#include "core/simd/prefetch.hpp"
#include "layout/reject_tree.hpp"

namespace clbvh::layout {
namespace {

/// Nodes of a part, about, and most parts.
constexpr std::size_t kNodesOfPart = 4096;
constexpr std::size_t kMostParts = 1024;

/// What a task has found below a node.
struct Measure {
    std::uint64_t nodes = 0;
    std::uint64_t ids = 0;
    std::uint32_t depth = 0;
};

/// Finds the parts of a tree. Whatever the nodes hold, it reads nothing out of range, and ends after about as many
/// steps as there are nodes.
class PartFinder {
public:
    PartFinder(const Bvh& bvh, std::atomic<std::uint8_t>* pairs) : bvh_(bvh), nodes_(bvh.nodes.data()), pairs_(pairs) {}

    std::optional<TreeParts> find() {
        open_top();
        std::vector<Part> parts = in_depth_first_order();
        tbb::parallel_for(
            std::size_t{0}, parts.size(), [&](std::size_t i) { measure_part(parts[i]); }, tbb::simple_partitioner{});
        if (has_fault_.load(std::memory_order_relaxed)) return std::nullopt;
        number(parts);
        return TreeParts{std::move(parts), depth_.load(std::memory_order_relaxed)};
    }

private:
    static constexpr std::uint32_t kNone = ~0U;

    /// A node of the top, or just below it.
    struct Open {
        std::uint32_t node;
        std::uint32_t depth;
        std::uint32_t children = kNone;  ///< Place of the first of them; kNone: a part of its own.
    };

    /// False where the children of an inner node are none.
    [[nodiscard]] bool has_children(const Node& node) const noexcept {
        return node.first % 2 == 0 && node.first > 0 && std::size_t{node.first} + 1 < bvh_.nodes.size();
    }
    [[nodiscard]] bool has_ids(const Node& leaf) const noexcept {
        return std::uint64_t{leaf.first} + leaf.count <= bvh_.primitive_ids.size();
    }
    void mark_children(const Node& node) const noexcept {
        if (pairs_ != nullptr) pairs_[node.first / 2].store(1, std::memory_order_relaxed);
    }

    /// Level by level, until there are enough subtrees below. In a tree that is a chain that will never be.
    void open_top() {
        const std::size_t wanted = std::min(bvh_.nodes.size() / kNodesOfPart, kMostParts);
        top_.push_back({0, 0});
        for (std::size_t i = 0; i < top_.size() && i < 4 * wanted && top_.size() - i < wanted; ++i) {
            const Node& node = nodes_[top_[i].node];
            if (node.is_leaf()) continue;
            if (!has_children(node)) return has_fault_.store(true, std::memory_order_relaxed);
            mark_children(node);
            const std::uint32_t depth = top_[i].depth + 1;
            top_[i].children = static_cast<std::uint32_t>(top_.size());
            top_.push_back({node.first, depth});
            top_.push_back({node.first + 1, depth});
        }
    }

    [[nodiscard]] std::vector<Part> in_depth_first_order() const {
        std::vector<Part> parts;
        parts.reserve(top_.size());
        std::vector<std::uint32_t> stack{0};
        while (!stack.empty()) {
            const Open open = top_[stack.back()];
            stack.pop_back();
            parts.push_back({open.node, open.depth, open.children == kNone});
            if (open.children != kNone) stack.insert(stack.end(), {open.children + 1, open.children});
        }
        return parts;
    }

    void measure_part(Part& part) {
        if (!part.is_subtree) {
            add_steps(1);
            return;
        }
        const Measure measure = measure_below(part);
        part.node_count = static_cast<std::uint32_t>(measure.nodes);
        part.id_count = static_cast<std::uint32_t>(measure.ids);
        std::uint32_t depth = depth_.load(std::memory_order_relaxed);
        while (measure.depth > depth &&
               !depth_.compare_exchange_weak(depth, measure.depth, std::memory_order_relaxed)) {
        }
        total_ids_.fetch_add(measure.ids, std::memory_order_relaxed);
        if (total_ids_.load(std::memory_order_relaxed) > bvh_.primitive_ids.size()) give_up();
    }

    /// Children that a walk has come to know of.
    struct Pair {
        std::uint32_t first = 0, depth = 0;
    };

    /// Walks over a subtree, some pairs at a time, so that what was asked for is there when its turn comes.
    Measure measure_below(const Part& part) {
        constexpr std::size_t kPairsAtOnce = 16, kStepsAtOnce = 1024;
        Measure measure{.nodes = 1, .depth = part.depth};
        std::uint64_t added = 0;
        std::vector<Pair> stack;
        look_at(nodes_[part.node], part.depth, measure, stack);
        while (!stack.empty()) {
            std::array<Pair, kPairsAtOnce> pairs;
            const std::size_t count = std::min(stack.size(), kPairsAtOnce), left = stack.size() - count;
            std::copy_n(stack.data() + left, count, pairs.data());
            stack.resize(left);
            for (const Pair& pair : std::span(pairs).first(count)) {
                measure.depth = std::max(measure.depth, pair.depth);
                look_at(nodes_[pair.first], pair.depth, measure, stack);
                look_at(nodes_[pair.first + 1], pair.depth, measure, stack);
            }
            measure.nodes += 2 * count;
            if (measure.nodes - added < kStepsAtOnce) continue;
            if (!add_steps(measure.nodes - added)) return measure;
            added = measure.nodes;
        }
        add_steps(measure.nodes - added);
        return measure;
    }

    void look_at(const Node& node, std::uint32_t depth, Measure& measure, std::vector<Pair>& stack) {
        if (node.is_leaf()) {
            measure.ids += node.count;
            if (!has_ids(node)) give_up();
        } else if (has_children(node)) {
            prefetch(&nodes_[node.first]);
            mark_children(node);
            stack.push_back({node.first, depth + 1});
        } else {
            give_up();
        }
    }

    /// False where some task has met a fault. More steps than there are nodes are one.
    bool add_steps(std::uint64_t steps) {
        if (steps_.fetch_add(steps, std::memory_order_relaxed) + steps > bvh_.nodes.size()) give_up();
        return !has_fault_.load(std::memory_order_relaxed);
    }
    void give_up() { has_fault_.store(true, std::memory_order_relaxed); }

    /// From the last part to the first, so that both children are known before their parent.
    static void number(std::vector<Part>& parts) {
        std::vector<Part*> below;
        for (auto part = parts.rbegin(); part != parts.rend(); ++part) {
            if (!part->is_subtree) {
                part->node_count = 1;
                part->nodes_of_first_child = below.back()->node_count;
                for (int child = 0; child < 2; ++child) {
                    part->node_count += below.back()->node_count;
                    part->id_count += below.back()->id_count;
                    below.pop_back();
                }
            }
            below.push_back(&*part);
        }
        std::uint32_t node = 0, id = 0;
        for (Part& part : parts) {
            part.first_node = node;
            part.first_id = id;
            node += part.is_subtree ? part.node_count : 1;
            id += part.is_subtree ? part.id_count : 0;
        }
    }

    const Bvh& bvh_;
    const Node* nodes_;
    std::atomic<std::uint8_t>* pairs_;
    std::vector<Open> top_;
    std::atomic<bool> has_fault_ = false;
    std::atomic<std::uint64_t> steps_ = 0;
    std::atomic<std::uint64_t> total_ids_ = 0;
    std::atomic<std::uint32_t> depth_ = 0;
};

}  // namespace

std::optional<TreeParts> find_parts(const Bvh& bvh, std::atomic<std::uint8_t>* pairs) {
    return PartFinder(bvh, pairs).find();
}

DepthFirst::DepthFirst(const Bvh& bvh) {
    std::optional<TreeParts> found = find_parts(bvh);
    if (!found) reject_tree(bvh);
    tree_ = std::move(*found);
}

}  // namespace clbvh::layout
