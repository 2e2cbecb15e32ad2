// Karras, Aila 2013, "Fast Parallel Construction of High-Quality Bounding Volume Hierarchies", section 3.
#include "clbvh/optimize/treelet.hpp"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <limits>
#include <utility>
#include <vector>

#include "core/bottom_up.hpp"
#include "core/check_field.hpp"
#include "core/exact_areas.hpp"
#include "optimize/pass_clock.hpp"
#include "optimize/run_optimizer.hpp"
#include "optimize/treelet_search.hpp"

namespace clbvh {
namespace {

using optimizer::TreeletSearch;

constexpr std::uint32_t kPasses = 3;
constexpr std::size_t kMostLeaves = TreeletSearch::kMostLeaves;

/// The nodes at the top of a subtree: its inner ones but the root as pairs of slots, and its leaves, which may be inner
/// nodes of the whole tree.
class Treelet {
public:
    /// Grows by taking the largest leaf that is an inner node apart, up to `most` leaves.
    Treelet(const std::vector<Node>& nodes, std::uint32_t root, std::size_t most) {
        take_apart(nodes, nodes[root]);
        while (leaf_count_ < most) {
            const std::size_t largest = find_largest();
            if (largest == leaf_count_) break;
            const Node node = leaves_[largest];
            area_ += areas_[largest];
            leaves_[largest] = leaves_[--leaf_count_];
            areas_[largest] = areas_[leaf_count_];
            take_apart(nodes, node);
        }
    }

    [[nodiscard]] std::span<const Node> leaves() const noexcept { return {leaves_.data(), leaf_count_}; }
    /// Slots of its sibling pairs, the root's first; one less than there are leaves.
    [[nodiscard]] std::uint32_t pair(std::size_t i) const noexcept { return pairs_[i]; }
    /// The sum of the half areas of its inner nodes, the root excluded.
    [[nodiscard]] double area() const noexcept { return area_; }

private:
    void take_apart(const std::vector<Node>& nodes, const Node& node) {
        pairs_[pair_count_++] = node.first;
        for (const std::uint32_t child : {node.first, node.first + 1}) {
            areas_[leaf_count_] = exact_half_area(nodes[child]);
            leaves_[leaf_count_++] = nodes[child];
        }
    }

    [[nodiscard]] std::size_t find_largest() const {
        std::size_t largest = leaf_count_;
        for (std::size_t i = 0; i < leaf_count_; ++i) {
            if (!leaves_[i].is_leaf() && (largest == leaf_count_ || areas_[i] > areas_[largest])) largest = i;
        }
        return largest;
    }

    std::array<Node, kMostLeaves> leaves_;
    std::array<double, kMostLeaves> areas_;
    std::array<std::uint32_t, kMostLeaves> pairs_;
    std::size_t leaf_count_ = 0;
    std::size_t pair_count_ = 0;
    double area_ = 0.0;
};

class TreeletOptimizer {
public:
    TreeletOptimizer(Bvh& tree, const TreeletConfig& config)
        : nodes_(tree.nodes), config_(config), clock_("treelet", config.budget, kPasses), sizes_(nodes_.size() / 2) {}

    OptimizeStats run() {
        const auto visit = [this](std::uint32_t node) { optimize_at(node); };
        Scratch scratch;
        std::uint64_t least_size = config_.least_size;
        while (clock_.may_begin_pass()) {
            least_size_ = static_cast<std::uint32_t>(std::min<std::uint64_t>(least_size, sizes_.size()));
            changes_ = 0;
            scratch.reset();
            BottomUp<decltype(visit)>(nodes_, scratch, visit).run();
            clock_.end_pass(changes_);
            least_size = 2 * least_size;
        }
        return clock_.finish();
    }

private:
    [[nodiscard]] std::uint32_t size_of(const Node& node) const noexcept {
        return node.is_leaf() ? 1 : sizes_[node.first / 2];
    }

    /// Every inner node below `root` was visited before it.
    void optimize_at(std::uint32_t root) {
        const std::uint32_t first = nodes_[root].first;
        const std::uint32_t size = size_of(nodes_[first]) + size_of(nodes_[first + 1]);
        sizes_[first / 2] = size;
        if (size < std::max(3u, least_size_)) return;
        const Treelet treelet(nodes_, root, config_.leaves);
        std::array<Box4, kMostLeaves> boxes;
        std::ranges::transform(treelet.leaves(), boxes.begin(), [](const Node& leaf) {
            return Box4{Float4::load(leaf.lower).without_w(), Float4::load(leaf.upper).without_w()};
        });
        TreeletSearch& search = searches_.local();
        search.run({boxes.data(), treelet.leaves().size()});
        // In single precision first, which is wrong by less than this.
        constexpr double kDoubt = 1.0 + 1e-5;
        const double root_area = exact_half_area(nodes_[root]);
        if (double{search.least_area()} > (treelet.area() + root_area) * kDoubt) return;
        if (exact_area(search, boxes) >= treelet.area()) return;
        std::size_t pairs_used = 0;
        write(root, search.all(), search, treelet, pairs_used);
        changes_.fetch_add(1, std::memory_order_relaxed);
    }

    /// The sum of the half areas of the best tree's inner nodes but the root.
    [[nodiscard]] static double exact_area(const TreeletSearch& search, std::span<const Box4> boxes) {
        double sum = 0.0;
        std::array<std::uint32_t, 2 * kMostLeaves> stack{search.all()};
        for (std::size_t size = 1; size > 0;) {
            const std::uint32_t subset = stack[--size];
            for (const std::uint32_t part : {search.part_of(subset), subset ^ search.part_of(subset)}) {
                if (std::has_single_bit(part)) continue;
                Box4 box;
                for (std::uint32_t rest = part; rest != 0; rest &= rest - 1)
                    box.merge(boxes[static_cast<std::size_t>(std::countr_zero(rest))]);
                sum += exact_half_area(make_node(box, 0, 0));
                stack[size++] = part;
            }
        }
        return sum;
    }

    /// Writes the best tree over `subset` with its root in `slot`, in the pairs that the treelet has; returns its size.
    std::uint32_t write(std::uint32_t slot, std::uint32_t subset, const TreeletSearch& search, const Treelet& treelet,
                        std::size_t& pairs_used) {
        if (std::has_single_bit(subset)) {
            nodes_[slot] = treelet.leaves()[static_cast<std::size_t>(std::countr_zero(subset))];
            return size_of(nodes_[slot]);
        }
        const std::uint32_t pair = treelet.pair(pairs_used++);
        const std::uint32_t part = search.part_of(subset);
        const std::uint32_t size = write(pair, part, search, treelet, pairs_used) +
                                   write(pair + 1, subset ^ part, search, treelet, pairs_used);
        Box4 box = Box4::of(nodes_[pair]);
        box.merge(Box4::of(nodes_[pair + 1]));
        nodes_[slot] = make_node(box, pair, 0);
        sizes_[pair / 2] = size;
        return size;
    }

    std::vector<Node>& nodes_;
    const TreeletConfig& config_;
    optimizer::PassClock clock_;
    std::vector<std::uint32_t> sizes_;  // leaves below the parent of pair p
    tbb::enumerable_thread_specific<TreeletSearch> searches_;
    std::uint32_t least_size_ = 0;
    std::atomic<std::uint64_t> changes_ = 0;
};

}  // namespace

Bvh restructure_treelets(Bvh tree, const TreeletConfig& config, OptimizeStats* stats) {
    check_range("leaves", config.leaves, 3, TreeletSearch::kMostLeaves);
    return optimizer::run_optimizer(std::move(tree), config.budget, "treelet restructuring", stats,
                                    [&](Bvh& improved) { return TreeletOptimizer(improved, config).run(); });
}

}  // namespace clbvh
