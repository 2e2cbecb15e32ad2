#include "build/finish_stage.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "catalog/optimizer_rows.hpp"
#include "host/build/host_stages.hpp"
#include "host/collapse.hpp"

namespace clbvh {
namespace {

constexpr double kCollapseBegins = 0.95;  // of the whole build

std::uint64_t bytes_of(const Bvh& tree) {
    return tree.nodes.size() * sizeof(Node) + tree.primitive_ids.size() * sizeof(std::uint32_t);
}

/// Puts sources in the place of parts, in each leaf once and ascending. The tree has no nodes that are not in use.
void name_sources(Bvh& tree, std::span<const std::uint32_t> sources) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, tree.nodes.size(), 4096), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            Node& leaf = tree.nodes[i];
            const auto ids = std::span(tree.primitive_ids).subspan(leaf.is_leaf() ? leaf.first : 0, leaf.count);
            for (std::uint32_t& id : ids)
                id = sources[id];
            std::ranges::sort(ids);
            leaf.count = static_cast<std::uint32_t>(std::unique(ids.begin(), ids.end()) - ids.begin());
        }
    });
}

}  // namespace

void FinishStage::optimize(Bvh& tree, host::HostStages& stages, double begin) const {
    constexpr std::uint64_t kWork = 1000;
    const std::vector<std::string_view> ids = optimizer_ids(options_.optimizers);
    const double share = (kCollapseBegins - begin) / static_cast<double>(ids.size());
    for (const std::string_view id : ids) {
        stages.begin(id, begin, begin + share, kWork);
        begin += share;
        OptimizeBudget budget;
        budget.passes = options_.optimize_passes;
        std::uint64_t done = 0;
        // Cancels by an exception, as every stage of a build does.
        budget.progress = [&](const Progress& progress) {
            const auto now = static_cast<std::uint64_t>(progress.fraction * static_cast<double>(kWork));
            stages.advance(now - std::min(done, now));
            done = std::max(done, now);
            return true;
        };
        tree = run_optimizer(std::move(tree), id, budget);
    }
}

void FinishStage::run(Backend& backend, const Input& input, double begin, BuildStats& stats) {
    host::HostStages stages(options_.progress);
    const double middle = begin + 0.1 * (kCollapseBegins - begin);
    if (backend.is_remote()) stages.begin("download", begin, middle);
    Bvh& tree = backend.tree();
    if (optimizes_on_host(options_)) optimize(tree, stages, middle);
    if (input.is_presplit || options_.max_leaf_size > 0) {
        stages.begin("collapse", kCollapseBegins, 1.0);
        if (input.is_presplit) {
            name_sources(tree, input.sources);
            tree.split_references = true;
            tree.primitive_count = input.primitive_count;
        }
        // Without a size, only leaves that came from one primitive are merged again.
        const CollapseConfig config{std::max(options_.max_leaf_size, 1u), options_.inner_cost, options_.primitive_cost};
        host::collapse(tree, config, scratch_, result_);
    } else {
        scratch_.reset();
        std::swap(result_, tree);  // the backend writes the next one into the memory of the last
    }
    const BuildStats cost = stages.finish();
    stats.stages.insert(stats.stages.end(), cost.stages.begin(), cost.stages.end());
    stats.build_ms += cost.build_ms;
    stats.peak_host_bytes += scratch_.bytes_in_use() + bytes_of(result_) + (backend.is_remote() ? bytes_of(tree) : 0);
}

}  // namespace clbvh
