#include "nine_tree.hpp"

#include <tbb/task_arena.h>

#include <clbvh/builder.hpp>
#include <clbvh/host/collapse.hpp>
#include <utility>

#include "build_result.hpp"
#include "interrupt.hpp"
#include "open_builder.hpp"
#include "stopwatch.hpp"

namespace clbvh::tool {
namespace {

constexpr std::string_view kAnneal = "anneal";  // has settings of its own here

BuildOptions options_of(const NineBuilder& nine, const NineTreeSettings& settings, const ProgressCallback& progress) {
    BuildOptions options = settings.options;
    options.progress = progress;
    if (nine.optimizers != kAnneal) options.optimizers = nine.optimizers;
    if (!nine.merges_leaves || nine.optimizers == kAnneal) options.max_leaf_size = 0;
    return options;
}

NineTree build_tree(const NineBuilder& nine, const NineTreeSettings& settings, const Mesh& mesh,
                    const ProgressCallback& progress) {
    Builder builder = open_builder(nine.builder, settings.context, options_of(nine, settings, progress));
    builder.upload(mesh);
    if (nine.optimizers.empty()) builder.run();
    NineTree tree;
    tree.build_ms = builder.run().build_ms;
    tree.bvh = builder.download();
    return tree;
}

/// Merges leaves as Builder does it.
void merge_leaves(NineTree& tree, const BuildOptions& options) {
    if (options.max_leaf_size == 0) return;
    const Stopwatch stopwatch;
    tree.bvh = collapse(tree.bvh, {options.max_leaf_size, options.inner_cost, options.primitive_cost});
    tree.build_ms += stopwatch.milliseconds();
}

void anneal_tree(NineTree& tree, const NineTreeSettings& settings, const ProgressCallback& progress) {
    AnnealConfig config = settings.annealing;
    config.budget = {};
    config.budget.progress = progress;
    OptimizeStats stats;
    tree.bvh = anneal(std::move(tree.bvh), config, &stats);
    throw_if_interrupted();
    tree.build_ms += stats.milliseconds;
    merge_leaves(tree, settings.options);
}

}  // namespace

NineTree build_nine_tree(const NineBuilder& nine, const NineTreeSettings& settings, const Mesh& mesh,
                         const std::string& label, ProgressBar& bar) {
    throw_if_interrupted();
    bar.show_now(0.0, label);
    const ProgressCallback progress = [&](const Progress& work) {
        bar.show(work.fraction, label);
        return !interrupted();
    };
    NineTree tree = build_tree(nine, settings, mesh, progress);
    if (nine.optimizers == kAnneal) {
        tbb::task_arena arena(static_cast<int>(host_threads(settings.options)));
        arena.execute([&] { anneal_tree(tree, settings, progress); });
    }
    return tree;
}

}  // namespace clbvh::tool
