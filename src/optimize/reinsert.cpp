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
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "core/check_field.hpp"
#include "core/memory_errors.hpp"
#include "optimize/pass_clock.hpp"
#include "optimize/reinsertion.hpp"

namespace clbvh {
namespace {

using optimize::EditTree;
using optimize::exact_half_area;
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
    /// The nodes that this pass tries to move, and the sum of the areas of all inner ones.
    void select_candidates() {
        all_.resize(tree_.slot_count() / 2 * 2);
        struct Sums {
            double area = 0.0;
            std::size_t nodes = 0;
        };
        const std::size_t pairs = tree_.slot_count() / 2;
        // Of each pair both or neither is a candidate's slot; what is none has no worth and sorts behind.
        const Sums sums = tbb::parallel_deterministic_reduce(
            tbb::blocked_range<std::size_t>(0, pairs, 8192), Sums{},
            [&](const auto& range, Sums sum) {
                for (std::size_t pair = range.begin(); pair < range.end(); ++pair)
                    add_pair(static_cast<std::uint32_t>(2 * pair), sum.area, sum.nodes);
                return sum;
            },
            [](const Sums& a, const Sums& b) {
                return Sums{a.area + b.area, a.nodes + b.nodes};
            });
        area_before_ = sums.area;
        const auto wanted =
            static_cast<std::size_t>(static_cast<double>(config_.candidates) * static_cast<double>(sums.nodes));
        const std::size_t count = std::min(sums.nodes, std::max<std::size_t>(1, wanted));
        if (count < all_.size())
            std::nth_element(all_.begin(), all_.begin() + static_cast<std::ptrdiff_t>(count), all_.end());
        all_.resize(count);
    }

    void add_pair(std::uint32_t slot, double& area, std::size_t& nodes) {
        const std::uint32_t parent = slot == 0 ? EditTree::kUnused : tree_.parent(slot);
        all_[slot] = all_[slot + 1] = {-1.0f, slot};
        if (parent == EditTree::kUnused) return;
        area += exact_half_area(tree_[parent]);
        if (parent == 0) return;
        const float parent_area = tree_.box(parent).half_area();
        for (const std::uint32_t node : {slot, slot + 1})
            all_[node] = {parent_area - tree_.box(node).half_area(), node};
        nodes += 2;
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
    const OptimizeStats done = with_memory_errors("reinsertion", [&] {
        if (tree.empty() || tree.nodes[0].is_leaf()) return OptimizeStats{};
        return Reinserter(tree, config).run();
    });
    if (stats != nullptr) *stats = done;
    return tree;
}

}  // namespace clbvh
