// Bittner, Hapala, Havran 2013, "Fast Insertion-Based Optimization of Bounding Volume Hierarchies".
//
// The paper removes a node, with it its parent, and inserts its two children again, the larger first. Here each child
// moves by itself, and stays where no place is better: the same trees can be reached, and the cost never rises. The
// search climbs from the child's old place instead of descending from the root; both find the best place there is.
#include <algorithm>
#include <array>
#include <vector>

#include "clbvh/optimize/reinsert.hpp"
#include "core/check_field.hpp"
#include "core/exact_areas.hpp"
#include "core/random.hpp"
#include "optimize/pass_clock.hpp"
#include "optimize/reinsertion.hpp"
#include "optimize/run_optimizer.hpp"

namespace clbvh {
namespace {

using optimizer::EditTree;

constexpr std::uint32_t kMostPasses = 1000;
constexpr std::uint32_t kPassesPerLook = 10;  // at what they saved
// Where the worst nodes cannot be improved, others can: every other pass takes nodes at random (section 3.2.2).
constexpr std::uint32_t kRandomPass = 2;
constexpr std::uint64_t kSeed = 1;
constexpr std::size_t kMovesBetweenLooks = 1024;  // at the clock

class BatchReinserter {
public:
    BatchReinserter(Bvh& tree, const ReinsertBatchesConfig& config)
        : clock_("reinsert-batches", config.budget, kMostPasses),
          tree_(tree.nodes),
          config_(config),
          search_(tree_),
          move_(tree_) {}

    OptimizeStats run() {
        double area = tree_.inner_half_area();
        for (std::uint32_t pass = 1; clock_.may_begin_pass(); ++pass) {
            select(pass % kRandomPass == 0);
            if (!run_pass()) break;
            if (pass % kPassesPerLook != 0) continue;
            const double area_now = tree_.inner_half_area();
            if (area - area_now <= double{config_.least_gain} * area) break;
            area = area_now;
        }
        return clock_.finish();
    }

private:
    struct Rated {
        double rating;
        std::uint32_t node;

        friend bool operator<(const Rated& a, const Rated& b) noexcept {
            return a.rating != b.rating ? a.rating > b.rating : a.node < b.node;
        }
    };

    /// The inner nodes of this pass, the worst first, or random ones.
    void select(bool at_random) {
        rated_.clear();
        for (std::uint32_t pair = 1; pair < tree_.slot_count() / 2; ++pair) {
            const std::uint32_t node = tree_.parent(2 * pair);
            if (node == EditTree::kUnused || node == 0) continue;
            rated_.push_back({at_random ? random_.unit() : inefficiency(node), node});
        }
        const auto wanted =
            static_cast<std::size_t>(static_cast<double>(config_.batch) * static_cast<double>(rated_.size()));
        const std::size_t count = std::min(rated_.size(), std::max<std::size_t>(wanted, 1));
        const auto end = rated_.begin() + static_cast<std::ptrdiff_t>(count);
        std::partial_sort(rated_.begin(), end, rated_.end());
        rated_.resize(count);
    }

    /// Section 3.2.1: the product of the area, its ratio to the mean of the children's, and its ratio to the least.
    [[nodiscard]] double inefficiency(std::uint32_t node) const {
        const double area = exact_half_area(tree_[node]);
        const double left = exact_half_area(tree_[tree_[node].first]);
        const double right = exact_half_area(tree_[tree_[node].first + 1]);
        const double mean = 0.5 * (left + right);
        const double least = std::min(left, right);
        // Of flat children nothing can be said but that they are small.
        return area * (mean > 0.0 ? area / mean : 1.0) * (least > 0.0 ? area / least : 1.0);
    }

    [[nodiscard]] bool run_pass() {
        std::uint64_t changes = 0;
        for (std::size_t i = 0; i < rated_.size(); ++i) {
            if (i % kMovesBetweenLooks == 0 &&
                !clock_.may_go_on(static_cast<double>(i) / static_cast<double>(rated_.size()))) {
                return false;
            }
            changes += reinsert_children(rated_[i].node);
        }
        clock_.end_pass(changes);
        return true;
    }

    /// Earlier moves of the pass may have put something else into the slot, even a leaf.
    std::uint64_t reinsert_children(std::uint32_t node) {
        std::uint64_t changes = 0;
        for (int turn = 0; turn < 2; ++turn) {
            if (tree_[node].is_leaf()) break;
            const std::uint32_t left = tree_[node].first;
            const bool right_is_larger = exact_half_area(tree_[left + 1]) > exact_half_area(tree_[left]);
            const std::uint32_t child = left + (right_is_larger == (turn == 0) ? 1 : 0);
            const optimizer::Reinsertion found = search_.find(child);
            if (found.gain > 0.0f && move_.make(found.from, found.to) > 0.0) ++changes;
        }
        return changes;
    }

    optimizer::PassClock clock_;  // runs from before the tree's nodes are found
    EditTree tree_;
    const ReinsertBatchesConfig& config_;
    optimizer::ReinsertionSearch search_;
    optimizer::ReinsertionMove move_;
    std::vector<Rated> rated_;
    Random random_{kSeed};
};

}  // namespace

Bvh reinsert_batches(Bvh tree, const ReinsertBatchesConfig& config, OptimizeStats* stats) {
    check_range("batch", config.batch, 1e-9f, 1.0f);
    check_range("least_gain", config.least_gain, 0.0f, 1.0f);
    return optimizer::run_optimizer(std::move(tree), config.budget, "reinsertion", stats,
                                    [&](Bvh& improved) { return BatchReinserter(improved, config).run(); });
}

}  // namespace clbvh
