#include "aila2013/aila_tree.hpp"

#include <tbb/task_arena.h>

#include <clbvh/builder.hpp>
#include <clbvh/catalog.hpp>
#include <clbvh/host/collapse.hpp>
#include <utility>

#include "cli/interrupt.hpp"
#include "cli/open_builder.hpp"
#include "cli/stopwatch.hpp"
#include "measure/build_result.hpp"

namespace clbvh::tool {
namespace {

/// Of what Builder does: all of it, but optimising a tree whose leaves are merged already.
BuildOptions options_of(const AilaBuilder& way, const AilaTreeSettings& settings, const ProgressCallback& progress) {
    BuildOptions options = settings.options;
    options.progress = progress;
    if (way.leaves != LeafMerging::twice) options.optimizers = way.optimizers;
    if (way.leaves == LeafMerging::never) options.max_leaf_size = 0;
    return options;
}

AilaTree build_tree(const AilaBuilder& way, const AilaTreeSettings& settings, const Mesh& mesh,
                    const ProgressCallback& progress) {
    Builder builder = open_builder(way.builder, settings.context, options_of(way, settings, progress));
    builder.upload(mesh);
    if (way.optimizers.empty()) builder.run();
    AilaTree tree;
    tree.build_ms = builder.run().build_ms;
    tree.bvh = builder.download();
    return tree;
}

Bvh improve(Bvh bvh, const AilaBuilder& way, const AilaTreeSettings& settings, const ProgressCallback& progress) {
    OptimizeBudget budget;
    budget.progress = progress;
    if (way.optimizers != "anneal") return optimize(std::move(bvh), way.optimizers, budget);
    AnnealConfig config = settings.annealing;
    config.budget = budget;
    return anneal(std::move(bvh), config);
}

/// Beyond what Builder does: optimises the tree with the leaves that it has, and merges leaves once more.
void improve_and_merge(AilaTree& tree, const AilaBuilder& way, const AilaTreeSettings& settings,
                       const ProgressCallback& progress) {
    const BuildOptions& options = settings.options;
    const Stopwatch stopwatch;
    tree.bvh = improve(std::move(tree.bvh), way, settings, progress);
    throw_if_interrupted();
    if (options.max_leaf_size > 0)
        tree.bvh = collapse(tree.bvh, {options.max_leaf_size, options.inner_cost, options.primitive_cost});
    tree.build_ms += stopwatch.milliseconds();
}

}  // namespace

AilaTree build_aila_tree(const AilaBuilder& way, const AilaTreeSettings& settings, const Mesh& mesh,
                         const std::string& label, ProgressBar& bar) {
    throw_if_interrupted();
    bar.show_now(0.0, label);
    const ProgressCallback progress = [&](const Progress& work) {
        bar.show(work.fraction, label);
        return !interrupted();
    };
    AilaTree tree = build_tree(way, settings, mesh, progress);
    if (way.leaves == LeafMerging::twice) {
        tbb::task_arena arena(static_cast<int>(host_threads(settings.options)));
        arena.execute([&] { improve_and_merge(tree, way, settings, progress); });
    }
    return tree;
}

}  // namespace clbvh::tool
