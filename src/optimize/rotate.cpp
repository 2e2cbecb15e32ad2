// Kensler 2008, "Tree Rotations for Improving Bounding Volume Hierarchies": hill climbing and simulated annealing.
//
// The paper recurses over the tree; here unrelated subtrees are visited at once, and random numbers belong to a pass, a
// node and a candidate, so that the order of visits does not matter. Costs of subtrees need not be known: exchanges
// keep all leaves, so that only the areas of the children change.
#include "clbvh/optimize/rotate.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "core/bottom_up.hpp"
#include "core/check_field.hpp"
#include "core/exact_areas.hpp"
#include "core/random.hpp"
#include "optimize/pass_clock.hpp"
#include "optimize/run_optimizer.hpp"
#include "optimize/tree_rotation.hpp"

namespace clbvh {
namespace {

using optimizer::EditTree;
using optimizer::GreedyChoice;
using optimizer::PassClock;
using optimizer::TreeRotation;

constexpr std::uint32_t kMostPasses = 1000;
constexpr double kInnerCost = 10.0;  // that temperatures refer to; see AnnealConfig
constexpr std::uint32_t kLongestSchedule = 1000000;

/// Visits every inner node, children first, and makes the rotation that `choice_for(slot)` keeps, if any. Returns how
/// many it made. What a visit reads and writes lies below its node.
template <typename ChoiceFor>
std::uint64_t rotate_bottom_up(EditTree& tree, Scratch& scratch, const ChoiceFor& choice_for) {
    std::atomic<std::uint64_t> changes = 0;
    const auto visit = [&](std::uint32_t slot) {
        const TreeRotation rotation = best_rotation(tree, slot, choice_for(slot));
        if (!rotation) return;
        make_rotation(tree, slot, rotation);
        changes.fetch_add(1, std::memory_order_relaxed);
    };
    scratch.reset();
    BottomUp<decltype(visit)>(tree.nodes(), scratch, visit).run();
    return changes;
}

/// Passes of hill climbing, until nothing is found or one saves no more than `least_gain` of the area.
void climb(EditTree& tree, Scratch& scratch, PassClock& clock, double least_gain) {
    double area = tree.inner_half_area();
    while (clock.may_begin_pass()) {
        const std::uint64_t changes = rotate_bottom_up(tree, scratch, [](std::uint32_t) { return GreedyChoice{}; });
        clock.end_pass(changes);
        const double area_now = tree.inner_half_area();
        if (changes == 0 || area - area_now <= least_gain * area) return;
        area = area_now;
    }
}

/// Accepts a worse candidate with the probability that the temperature gives it (Boltzmann).
class HotChoice {
public:
    HotChoice(double temperature, double area, std::uint64_t seed)
        : temperature_(temperature), area_(area), seed_(seed) {}

    [[nodiscard]] bool operator()(const TreeRotation& best, const TreeRotation& candidate, std::uint32_t index) const {
        if (candidate.saved > best.saved) return true;
        // In the cost of this node alone, as the paper has it: relative to its area.
        const double rise = area_ > 0.0 ? kInnerCost * (best.saved - candidate.saved) / area_ : 0.0;
        return Random(seed_ + index).unit() < std::exp(-rise / temperature_);
    }

private:
    double temperature_;
    double area_;
    std::uint64_t seed_;
};

class Annealer {
public:
    Annealer(Bvh& tree, const AnnealConfig& config)
        : clock_("anneal", config.budget, config.length + kMostPasses),
          nodes_(tree.nodes),
          tree_(nodes_),
          config_(config) {}

    OptimizeStats run() {
        best_ = nodes_;
        best_area_ = tree_.inner_half_area();
        for (std::uint32_t pass = 0; pass < config_.length && clock_.may_begin_pass(); ++pass) {
            clock_.end_pass(run_pass(pass));
            keep_best();
        }
        climb(tree_, scratch_, clock_, 0.0);
        keep_best();
        nodes_ = std::move(best_);
        return clock_.finish();
    }

private:
    [[nodiscard]] double temperature(std::uint32_t pass) const {
        const double phase = 2.0 * std::numbers::pi * pass / double{config_.period};
        return std::max(0.0, -std::sin(phase)) * (config_.length - pass) * double{config_.hottest} / config_.length;
    }

    std::uint64_t run_pass(std::uint32_t pass) {
        const double now = temperature(pass);
        if (now <= 0.0) {
            return rotate_bottom_up(tree_, scratch_, [](std::uint32_t) { return GreedyChoice{}; });
        }
        const std::uint64_t pass_seed = Random::stream(config_.seed, pass).bits();
        return rotate_bottom_up(tree_, scratch_, [&](std::uint32_t slot) {
            return HotChoice(now, exact_half_area(tree_[slot]), Random(pass_seed + slot).bits());
        });
    }

    void keep_best() {
        const double area = tree_.inner_half_area();
        if (area >= best_area_) return;
        best_area_ = area;
        std::ranges::copy(nodes_, best_.begin());
    }

    PassClock clock_;  // runs from before the tree's nodes are found
    std::vector<Node>& nodes_;
    EditTree tree_;
    const AnnealConfig& config_;
    Scratch scratch_;
    std::vector<Node> best_;
    double best_area_ = 0.0;
};

/// Orders two siblings along the axis on which their boxes are farthest apart; a negative gap is an overlap.
void order_pair(Node& a, Node& b) {
    float widest = -std::numeric_limits<float>::infinity();
    bool is_b_lower = false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const float a_first = b.lower[axis] - a.upper[axis];
        const float b_first = a.lower[axis] - b.upper[axis];
        if (std::max(a_first, b_first) <= widest) continue;
        widest = std::max(a_first, b_first);
        is_b_lower = b_first > a_first;
    }
    if (is_b_lower) std::swap(a, b);
}

/// Of each two siblings the lower one first, as order_pair() has it. Kensler 2008, section 5.
void order_siblings(Bvh& tree) {
    // Whatever an unused slot holds stays unused.
    tbb::parallel_for(tbb::blocked_range<std::size_t>(1, tree.nodes.size() / 2, 8192), [&](const auto& pairs) {
        for (std::size_t pair = pairs.begin(); pair < pairs.end(); ++pair)
            order_pair(tree.nodes[2 * pair], tree.nodes[2 * pair + 1]);
    });
}

}  // namespace

Bvh rotate(Bvh tree, const RotateConfig& config, OptimizeStats* stats) {
    check_range("least_gain", config.least_gain, 0.0f, 1.0f);
    return optimizer::run_optimizer(std::move(tree), config.budget, "rotations", stats, [&](Bvh& improved) {
        PassClock clock("rotate", config.budget, kMostPasses);
        EditTree edited(improved.nodes);
        Scratch scratch;
        climb(edited, scratch, clock, config.least_gain);
        order_siblings(improved);
        return clock.finish();
    });
}

Bvh anneal(Bvh tree, const AnnealConfig& config, OptimizeStats* stats) {
    check_range("length", config.length, 1, kLongestSchedule);
    check_positive("period", config.period);
    check_range("hottest", config.hottest, 0.0f, 100.0f);
    return optimizer::run_optimizer(std::move(tree), config.budget, "annealing", stats, [&](Bvh& improved) {
        const OptimizeStats done = Annealer(improved, config).run();
        order_siblings(improved);
        return done;
    });
}

}  // namespace clbvh
