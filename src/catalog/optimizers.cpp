#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "catalog/optimizer_rows.hpp"
#include "clbvh/core/error.hpp"
#include "clbvh/optimize/rebuild.hpp"
#include "clbvh/optimize/rebuild_top.hpp"
#include "clbvh/optimize/reinsert.hpp"
#include "clbvh/optimize/rotate.hpp"
#include "clbvh/optimize/treelet.hpp"

#if defined(CLBVH_NO_OPENCL)
#define ON_DEVICE(row) nullptr
#else
#include "device/tree/device_optimizer_row.hpp"
#define ON_DEVICE(row) (&device::row)
#endif

namespace clbvh {
namespace {

struct OptimizerRow {
    OptimizerInfo info;
    Bvh (*run)(Bvh tree, const OptimizeBudget& budget, OptimizeStats& stats);
    const device::DeviceOptimizerRow* device_row = nullptr;  // on_device is whether there is one
};

/// `Run`, which takes a Config, with that Config's defaults within the budget.
template <typename Config, Bvh (*Run)(Bvh, const Config&, OptimizeStats*)>
Bvh run_within(Bvh tree, const OptimizeBudget& budget, OptimizeStats& stats) {
    Config config;
    config.budget = budget;
    return Run(std::move(tree), config, &stats);
}

// The table of optimisers. A new one is one row here.
const OptimizerRow kRows[] = {
    {.info = {.id = "reinsert",
              .title = "Parallel reinsertion: subtrees move where they cost least, found by branch and bound",
              .paper = "Meister, Bittner 2018"},
     .run = run_within<ReinsertConfig, reinsert>,
     .device_row = ON_DEVICE(kReinsert)},
    {.info = {.id = "reinsert-batches",
              .title = "The same, one subtree after the other, the worst nodes first",
              .paper = "Bittner, Hapala, Havran 2013"},
     .run = run_within<ReinsertBatchesConfig, reinsert_batches>},
    {.info = {.id = "treelet",
              .title = "Treelets of 7 leaves become the best trees over these leaves",
              .paper = "Karras, Aila 2013"},
     .run = run_within<TreeletConfig, restructure_treelets>,
     .device_row = ON_DEVICE(kTreelet)},
    {.info = {.id = "treelet-split",
              .title = "The same, after the triangles that have most to gain were split: a quota of 30 % more",
              .paper = "Karras, Aila 2013",
              .splits_first = true},
     .run = run_within<TreeletConfig, restructure_treelets>},
    {.info = {.id = "rebuild",
              .title =
                  "Subtrees are built anew by sweep SAH where that is cheaper: for scanned surfaces, before reinsert",
              .paper = "Yoon, Curtis, Manocha 2007"},
     .run = run_within<RebuildConfig, rebuild>},
    {.info = {.id = "rebuild-top",
              .title = "The top, the nodes with the largest boxes, is built anew by binned SAH where that is cheaper",
              .paper = "Pantaleoni, Luebke 2010"},
     .run = run_within<RebuildTopConfig, rebuild_top>},
    {.info = {.id = "rotate", .title = "Hill climbing by tree rotations", .paper = "Kensler 2008"},
     .run = run_within<RotateConfig, rotate>},
    {.info = {.id = "anneal",
              .title = "Simulated annealing by tree rotations, 1250 passes of them: the slowest by far",
              .paper = "Kensler 2008"},
     .run = run_within<AnnealConfig, anneal>},
};

/// Splits a triangle of optimisers that split first (Karras, Aila 2013, section 5).
constexpr float kSplitQuota = 0.3f;

const OptimizerRow& find_row(std::string_view id) {
    const auto row = std::ranges::find(kRows, id, [](const OptimizerRow& r) { return r.info.id; });
    if (row != std::end(kRows)) return *row;
    std::string known;
    for (const OptimizerRow& r : kRows)
        known += (known.empty() ? "" : ", ") + std::string(r.info.id);
    throw Error(ErrorCode::invalid_input, "unknown optimizer '" + std::string(id) + "'; known are: " + known);
}

/// The rows of ids with commas between them.
std::vector<const OptimizerRow*> find_rows(std::string_view ids) {
    std::vector<const OptimizerRow*> rows;
    for (const std::string_view id : optimizer_ids(ids))
        rows.push_back(&find_row(id));
    return rows;
}

/// The budget of the i-th of `count` optimisers, whose progress is a part of the whole.
OptimizeBudget part_of(const OptimizeBudget& budget, std::size_t i, std::size_t count) {
    OptimizeBudget part = budget;
    if (!budget.progress) return part;
    part.progress = [progress = budget.progress, i, count](const Progress& of_part) {
        return progress({of_part.stage, (static_cast<double>(i) + of_part.fraction) / static_cast<double>(count)});
    };
    return part;
}

[[noreturn]] void refuse_finished_tree(std::string_view id) {
    throw Error(
        ErrorCode::invalid_input,
        std::string(id) + " splits triangles before a tree is built, for which this one is finished: build with " +
            "it (BuildOptions::optimizers, --optimize), or with BuildOptions::split_quota (--split-quota), and " +
            "give that tree to treelet");
}

}  // namespace

std::span<const OptimizerInfo> optimizers() noexcept {
    static const auto infos = [] {
        std::array<OptimizerInfo, std::size(kRows)> list;
        std::ranges::transform(kRows, list.begin(), [](const OptimizerRow& row) {
            OptimizerInfo info = row.info;
            info.on_device = row.device_row != nullptr;
            return info;
        });
        return list;
    }();
    return infos;
}

const OptimizerInfo& find_optimizer(std::string_view id) {
    return optimizers()[static_cast<std::size_t>(&find_row(id) - kRows)];
}

std::vector<std::string_view> optimizer_ids(std::string_view list) {
    std::vector<std::string_view> ids;
    if (list.empty()) return ids;
    for (std::size_t begin = 0; begin <= list.size();) {
        const std::size_t end = std::min(list.find(',', begin), list.size());
        ids.push_back(list.substr(begin, end - begin));
        begin = end + 1;
    }
    return ids;
}

Bvh run_optimizer(Bvh tree, std::string_view id, const OptimizeBudget& budget, OptimizeStats* stats) {
    OptimizeStats unused;
    return find_row(id).run(std::move(tree), budget, stats != nullptr ? *stats : unused);
}

BuildOptions with_split_of_optimizers(BuildOptions options) {
    for (const OptimizerRow* row : find_rows(options.optimizers)) {
        if (!row->info.splits_first) continue;
        if (options.presplit_level > 0) {
            throw Error(ErrorCode::invalid_input, std::string(row->info.id) +
                                                      " splits triangles by split_quota: leave presplit_level alone, "
                                                      "or take treelet");
        }
        if (options.split_quota == 0.0f) options.split_quota = kSplitQuota;
    }
    return options;
}

void check_optimizers(std::string_view ids) {
    static_cast<void>(find_rows(ids));
}

const device::DeviceOptimizerRow* find_device_row(std::string_view id) {
    return find_row(id).device_row;
}

void check_device_optimizers(std::string_view ids) {
    for (const OptimizerRow* row : find_rows(ids)) {
        if (row->device_row == nullptr) {
            throw Error(ErrorCode::unsupported, "the optimizer " + std::string(row->info.id) +
                                                    " runs on the host only; take another, or let the host optimize");
        }
    }
}

Bvh optimize(Bvh tree, std::string_view ids, const OptimizeBudget& budget, OptimizeStats* stats) {
    const std::vector<const OptimizerRow*> rows = find_rows(ids);
    for (const OptimizerRow* row : rows) {
        if (row->info.splits_first) refuse_finished_tree(row->info.id);
    }
    OptimizeStats sums;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        OptimizeStats of_row;
        tree = rows[i]->run(std::move(tree), part_of(budget, i, rows.size()), of_row);
        sums.passes += of_row.passes;
        sums.changes += of_row.changes;
        sums.milliseconds += of_row.milliseconds;
        sums.is_cancelled = of_row.is_cancelled;
        if (sums.is_cancelled) break;
    }
    if (stats != nullptr) *stats = sums;
    return tree;
}

}  // namespace clbvh
