// Parallel reinsertion: Meister, Bittner 2018, "Parallel Reinsertion for Bounding Volume Hierarchy Optimization".
//
// It departs from the paper in three ways. Candidates are not every k-th node but those with the largest difference
// between the areas of parent and node, which bounds what a move can save before ancestors shrink: measured beside the
// node's own area and Bittner's measure, it saves most per search. There are no locks: moves are cheap beside searches,
// so they are made one after the other, by falling gain, and each proves its worth on the tree as it then is. And a
// node may also move beside one of its ancestors.
#include "clbvh/optimize/reinsert.hpp"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <atomic>
#include <utility>
#include <vector>

#include "core/check_field.hpp"
#include "optimize/pass_clock.hpp"
#include "optimize/reinsertion.hpp"
#include "optimize/run_optimizer.hpp"

namespace clbvh {
namespace {

using optimize::EditTree;
using optimize::PassClock;
using optimize::Reinsertion;
using optimize::ReinsertionMove;
using optimize::ReinsertionSearch;

constexpr std::uint32_t kMostPasses = 32;
constexpr std::size_t kSearchesBetweenLooks = std::size_t{1} << 17;  // at the clock: some tens of milliseconds

struct Candidate {
    float worth;
    std::uint32_t node;

    friend bool operator<(const Candidate& a, const Candidate& b) noexcept {
        return a.worth != b.worth ? a.worth > b.worth : a.node < b.node;
    }
};

class Reinserter {
public:
    Reinserter(Bvh& tree, const ReinsertConfig& config)
        : tree_(tree.nodes), config_(config), clock_("reinsert", config.budget, kMostPasses), move_(tree_) {}

    OptimizeStats run() {
        while (clock_.may_begin_pass()) {
            select_candidates();
            if (!search()) break;
            const double gain = make_moves();
            if (gain <= double{config_.least_gain} * area_before_) break;
        }
        return clock_.finish();
    }

private:
    /// Chooses the nodes that this pass tries to move.
    void select_candidates() {
        area_before_ = tree_.inner_half_area();
        all_.resize(tree_.slot_count());
        std::atomic<std::size_t> nodes = 0;
        tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, tree_.slot_count() / 2, 8192), [&](const auto& pairs) {
            std::size_t found = 0;
            for (std::uint32_t pair = pairs.begin(); pair < pairs.end(); ++pair)
                found += add_pair(2 * pair);
            nodes += found;
        });
        const auto wanted =
            static_cast<std::size_t>(static_cast<double>(config_.candidates) * static_cast<double>(nodes));
        const std::size_t count = std::min<std::size_t>(nodes, std::max<std::size_t>(1, wanted));
        if (count < all_.size())
            std::nth_element(all_.begin(), all_.begin() + static_cast<std::ptrdiff_t>(count), all_.end());
        all_.resize(count);
    }

    /// Rates the nodes of one pair of slots; returns how many of them may move. What may not sorts behind.
    std::size_t add_pair(std::uint32_t slot) {
        const std::uint32_t parent = slot == 0 ? EditTree::kUnused : tree_.parent(slot);
        const bool may_move = parent != EditTree::kUnused && parent != 0;
        const float parent_area = may_move ? tree_.box(parent).half_area() : 0.0f;
        for (const std::uint32_t node : {slot, slot + 1})
            all_[node] = {may_move ? parent_area - tree_.box(node).half_area() : -1.0f, node};
        return may_move ? 2 : 0;
    }

    /// Finds the candidates' best places. False where the budget ended that.
    bool search() {
        found_.resize(all_.size());
        for (std::size_t begin = 0; begin < all_.size(); begin += kSearchesBetweenLooks) {
            if (!clock_.may_go_on(static_cast<double>(begin) / static_cast<double>(all_.size()))) return false;
            const std::size_t end = std::min(all_.size(), begin + kSearchesBetweenLooks);
            tbb::parallel_for(tbb::blocked_range<std::size_t>(begin, end, 256), [&](const auto& range) {
                ReinsertionSearch& search = searches_.local();
                for (std::size_t i = range.begin(); i < range.end(); ++i)
                    found_[i] = search.find(all_[i].node);
            });
        }
        return true;
    }

    double make_moves() {
        std::erase_if(found_, [](const Reinsertion& move) { return !(move.gain > 0.0f); });
        tbb::parallel_sort(found_.begin(), found_.end(), [](const Reinsertion& a, const Reinsertion& b) {
            return a.gain != b.gain ? a.gain > b.gain : a.from < b.from;
        });
        double sum = 0.0;
        std::uint64_t made = 0;
        for (const Reinsertion& found : found_) {
            const double saved = move_.make(found.from, found.to);
            sum += saved;
            made += saved > 0.0 ? 1 : 0;
        }
        clock_.end_pass(made);
        return sum;
    }

    EditTree tree_;
    const ReinsertConfig& config_;
    PassClock clock_;
    ReinsertionMove move_;
    tbb::enumerable_thread_specific<ReinsertionSearch> searches_{[this] { return ReinsertionSearch(tree_); }};
    std::vector<Candidate> all_;  // all nodes, then the candidates
    std::vector<Reinsertion> found_;
    double area_before_ = 0.0;
};

}  // namespace

Bvh reinsert(Bvh tree, const ReinsertConfig& config, OptimizeStats* stats) {
    check_range("candidates", config.candidates, 1e-9f, 1.0f);
    check_range("least_gain", config.least_gain, 0.0f, 1.0f);
    return optimize::run_optimizer(std::move(tree), "reinsertion", stats,
                                   [&](Bvh& improved) { return Reinserter(improved, config).run(); });
}

}  // namespace clbvh
