// The top of a tree built anew by binned SAH over what is below it, where that is cheaper: the upper part of HLBVH
// (Pantaleoni, Luebke 2010) for any tree.
#include "clbvh/optimize/rebuild_top.hpp"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "core/check_field.hpp"
#include "host/top_down/cluster_top.hpp"
#include "optimize/pass_clock.hpp"
#include "optimize/run_optimizer.hpp"

namespace clbvh {
namespace {

constexpr std::uint32_t kPasses = 3;
constexpr std::uint32_t kShrink = 8;  // from pass to pass

class Rebuilder {
public:
    Rebuilder(Bvh& tree, const RebuildTopConfig& config)
        : nodes_(tree.nodes), config_(config), clock_("rebuild-top", config.budget, kPasses) {}

    OptimizeStats run() {
        top_.gather(nodes_, 0, nodes_[0], host::area_limit(nodes_, double{config_.share}));
        if (top_.inner.empty()) return clock_.finish();
        std::vector<std::uint32_t> roots{0};
        while (!roots.empty() && clock_.may_begin_pass())
            roots = rebuild(roots);
        return clock_.finish();
    }

private:
    /// One pass, over subtrees of the top. Returns those below them that may gain where they did not.
    [[nodiscard]] std::vector<std::uint32_t> rebuild(const std::vector<std::uint32_t>& roots) {
        std::vector<double> gains(roots.size());
        tbb::parallel_for(std::size_t{0}, roots.size(), [&](std::size_t i) {
            gains[i] = host::rebuild_top(nodes_, top_, roots[i], host::build_by_bins, workspaces_.local());
        });
        std::vector<std::uint32_t> next;
        for (std::size_t i = 0; i < roots.size(); ++i) {
            if (gains[i] == 0.0) add_parts(roots[i], next);
        }
        clock_.end_pass(
            static_cast<std::uint64_t>(std::ranges::count_if(gains, [](double gain) { return gain > 0.0; })));
        return next;
    }

    /// Adds the largest subtrees below `root` that have at most a kShrink-th of its clusters.
    void add_parts(std::uint32_t root, std::vector<std::uint32_t>& parts) const {
        const std::uint32_t most = top_.inner[root].cluster_count / kShrink;
        std::vector<std::uint32_t> stack{root};
        while (!stack.empty()) {
            const std::uint32_t part = stack.back();
            stack.pop_back();
            if (part == host::ClusterTop::kCluster || top_.inner[part].cluster_count < 3) continue;
            if (top_.inner[part].cluster_count <= most) {
                parts.push_back(part);
            } else {
                const auto [left, right] = top_.children(part);
                stack.insert(stack.end(), {right, left});
            }
        }
    }

    std::span<Node> nodes_;
    const RebuildTopConfig& config_;
    optimizer::PassClock clock_;
    host::ClusterTop top_;
    tbb::enumerable_thread_specific<host::TopWorkspace> workspaces_;
};

}  // namespace

Bvh rebuild_top(Bvh tree, const RebuildTopConfig& config, OptimizeStats* stats) {
    check_range("share", config.share, 0.0f, 1.0f);
    return optimizer::run_optimizer(std::move(tree), config.budget, "rebuilding the top", stats,
                                    [&](Bvh& improved) { return Rebuilder(improved, config).run(); });
}

}  // namespace clbvh
