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
#include <span>
#include <utility>
#include <vector>

#include "core/check_field.hpp"
#include "optimize/candidates.hpp"
#include "optimize/pass_clock.hpp"
#include "optimize/reinsertion.hpp"
#include "optimize/run_optimizer.hpp"

namespace clbvh {
namespace {

using optimizer::EditTree;
using optimizer::PassClock;
using optimizer::Reinsertion;
using optimizer::ReinsertionMove;
using optimizer::ReinsertionSearch;

constexpr std::uint32_t kMostPasses = 64;
// Most is gained by few moves at first, so that passes begin with few candidates, and take twice as many whenever one
// saves less than so much of the area. Against all candidates at once: the same cost in a fifth of the time.
constexpr double kFirstPart = 0.005;
constexpr double kGoodPass = 0.02;
constexpr std::size_t kSearchesBetweenLooks = std::size_t{1} << 17;  // at the clock: some tens of milliseconds

class Reinserter {
public:
    Reinserter(Bvh& tree, const ReinsertConfig& config)
        : clock_("reinsert", config.budget, kMostPasses),
          tree_(tree.nodes),
          config_(config),
          move_(tree_),
          candidates_(tree_) {}

    OptimizeStats run() {
        double area = candidates_.initial_area();
        double part = std::min(double{config_.candidates}, kFirstPart);
        while (clock_.may_begin_pass()) {
            if (!search(candidates_.choose(part))) break;
            const double gain = make_moves();
            const bool has_gained = gain > double{config_.least_gain} * area;
            if (!has_gained && part >= double{config_.candidates}) break;
            if (gain < kGoodPass * area) part = std::min(double{config_.candidates}, 2.0 * part);
            area -= gain;
        }
        return clock_.finish();
    }

private:
    /// Finds the candidates' best places. False where the budget ended that.
    bool search(std::span<const std::uint32_t> candidates) {
        found_.resize(candidates.size());
        for (std::size_t begin = 0; begin < candidates.size(); begin += kSearchesBetweenLooks) {
            if (!clock_.may_go_on(static_cast<double>(begin) / static_cast<double>(candidates.size()))) return false;
            const std::size_t end = std::min(candidates.size(), begin + kSearchesBetweenLooks);
            tbb::parallel_for(tbb::blocked_range<std::size_t>(begin, end, 256), [&](const auto& range) {
                ReinsertionSearch& search = searches_.local();
                for (std::size_t i = range.begin(); i < range.end(); ++i)
                    found_[i] = search.find(candidates[i]);
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
            if (!(saved > 0.0)) continue;
            ++made;
            move_.for_each_changed([&](std::uint32_t slot) { candidates_.touch(slot); });
        }
        clock_.end_pass(made);
        return sum;
    }

    PassClock clock_;  // runs from before the tree's nodes are found
    EditTree tree_;
    const ReinsertConfig& config_;
    ReinsertionMove move_;
    optimizer::Candidates candidates_;
    tbb::enumerable_thread_specific<ReinsertionSearch> searches_{[this] { return ReinsertionSearch(tree_); }};
    std::vector<Reinsertion> found_;
};

}  // namespace

Bvh reinsert(Bvh tree, const ReinsertConfig& config, OptimizeStats* stats) {
    check_range("candidates", config.candidates, 1e-9f, 1.0f);
    check_range("least_gain", config.least_gain, 0.0f, 1.0f);
    return optimizer::run_optimizer(std::move(tree), config.budget, "reinsertion", stats,
                                    [&](Bvh& improved) { return Reinserter(improved, config).run(); });
}

}  // namespace clbvh
