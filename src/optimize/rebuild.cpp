// Subtrees built anew where that is cheaper, as Yoon, Curtis, Manocha 2007, "Ray Tracing Dynamic Scenes using Selective
// Restructuring", do to trees of deforming meshes; here by the sweep of sweep_sah.hpp.
#include "clbvh/optimize/rebuild.hpp"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "core/bottom_up.hpp"
#include "core/check_field.hpp"
#include "core/exact_areas.hpp"
#include "host/top_down/cluster_top.hpp"
#include "optimize/pass_clock.hpp"
#include "optimize/run_optimizer.hpp"

namespace clbvh {
namespace {

constexpr std::uint32_t kPasses = 2;
constexpr float kNoLimit = -1.0f;
constexpr std::size_t kSubtreesBetweenLooks = 64;  // at the clock: some tens of milliseconds

/// The memory that a thread builds in.
struct Workspace {
    host::ClusterTop old;
    host::TopWorkspace build;
};

class Rebuilder {
public:
    Rebuilder(Bvh& tree, const RebuildConfig& config)
        : nodes_(tree.nodes), config_(config), clock_("rebuild", config.budget, kPasses), sizes_(nodes_.size() / 2) {}

    OptimizeStats run() {
        count_leaves();
        if (clock_.may_begin_pass() && rebuild_all(config_.subtree_leaves)) {
            const bool is_whole = sizes_[nodes_[0].first / 2] <= config_.subtree_leaves;
            const bool has_gained = gain_ >= double{config_.whole_gain} * area_;
            if (!is_whole && has_gained && clock_.may_begin_pass())
                rebuild_all(std::numeric_limits<std::uint32_t>::max());
        }
        return clock_.finish();
    }

private:
    /// Results of a task over its subtrees.
    struct Sums {
        double gain = 0.0;
        std::uint64_t changes = 0;
    };

    void count_leaves() {
        std::vector<double> areas(sizes_.size());
        const auto visit = [&](std::uint32_t node) {
            const std::uint32_t first = nodes_[node].first;
            sizes_[first / 2] = size_of(nodes_[first]) + size_of(nodes_[first + 1]);
            areas[first / 2] = exact_half_area(nodes_[node]);
        };
        Scratch scratch;
        BottomUp<decltype(visit)>(nodes_, scratch, visit).run();
        for (const double area : areas)
            area_ += area;
    }

    [[nodiscard]] std::uint32_t size_of(const Node& node) const noexcept {
        return node.is_leaf() ? 1 : sizes_[node.first / 2];
    }

    /// The largest subtrees of at most `most` leaves that can be built in more than one way.
    [[nodiscard]] std::vector<std::uint32_t> subtrees(std::uint32_t most) const {
        std::vector<std::uint32_t> found, stack{0};
        while (!stack.empty()) {
            const std::uint32_t slot = stack.back();
            stack.pop_back();
            const std::uint32_t size = size_of(nodes_[slot]);
            if (size > most) {
                stack.insert(stack.end(), {nodes_[slot].first + 1, nodes_[slot].first});
            } else if (size > 2) {
                found.push_back(slot);
            }
        }
        return found;
    }

    /// One pass. False where the budget ended it; what was done until then stays.
    bool rebuild_all(std::uint32_t most) {
        const std::vector<std::uint32_t> roots = subtrees(most);
        std::vector<Sums> sums(roots.size());
        bool is_whole = true;
        for (std::size_t begin = 0; begin < roots.size(); begin += kSubtreesBetweenLooks) {
            is_whole = clock_.may_go_on(static_cast<double>(begin) / static_cast<double>(roots.size()));
            if (!is_whole) break;
            const std::size_t end = std::min(roots.size(), begin + kSubtreesBetweenLooks);
            tbb::parallel_for(begin, end, [&](std::size_t i) { sums[i] = rebuild_at(roots[i]); });
        }
        std::uint64_t changes = 0;
        gain_ = 0.0;
        for (const Sums& of_root : sums) {
            gain_ += of_root.gain;
            changes += of_root.changes;
        }
        is_whole ? clock_.end_pass(changes) : clock_.break_off_pass(changes);
        return is_whole;
    }

    Sums rebuild_at(std::uint32_t root) {
        Workspace& space = workspaces_.local();
        space.old.gather(nodes_, root, nodes_[root], kNoLimit);
        const double gain = host::rebuild_top(nodes_, space.old, 0, host::build_by_sweep, space.build);
        return {gain, gain > 0.0 ? 1u : 0u};
    }

    std::vector<Node>& nodes_;
    const RebuildConfig& config_;
    optimizer::PassClock clock_;
    tbb::enumerable_thread_specific<Workspace> workspaces_;
    std::vector<std::uint32_t> sizes_;  // leaves below the parent of pair p
    double area_ = 0.0;                 // summed half areas of the inner nodes, before the first pass
    double gain_ = 0.0;                 // what the last pass took off that
};

}  // namespace

Bvh rebuild(Bvh tree, const RebuildConfig& config, OptimizeStats* stats) {
    check_range("subtree_leaves", config.subtree_leaves, 3, std::numeric_limits<std::uint32_t>::max());
    check_range("whole_gain", config.whole_gain, 0.0f, 1.0f);
    return optimizer::run_optimizer(std::move(tree), config.budget, "rebuilding", stats,
                                    [&](Bvh& improved) { return Rebuilder(improved, config).run(); });
}

}  // namespace clbvh
