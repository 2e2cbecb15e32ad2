#pragma once

#include <clbvh/core/bvh.hpp>
#include <clbvh/core/mesh.hpp>
#include <clbvh/device/context.hpp>
#include <clbvh/optimize/rotate.hpp>
#include <clbvh/options.hpp>
#include <optional>
#include <string>

#include "aila2013/aila_builders.hpp"
#include "cli/progress_bar.hpp"

namespace clbvh::tool {

/// How the trees of `clbvh table` are made.
struct AilaTreeSettings {
    BuildOptions options;            ///< `max_leaf_size` holds for builders that merge leaves.
    AnnealConfig annealing;          ///< Its budget is not read.
    std::optional<Context> context;  ///< Needed where a device builds.
};

/// A tree, and what it took.
struct AilaTree {
    Bvh bvh;
    double build_ms = 0.0;  ///< Wall time of building, optimising and merging leaves. A builder without an optimiser
                            ///< builds twice, and the second time counts.
};

/// The tree of one of the nine. `label` is what the bar shows. Throws what Builder throws, and Error(cancelled) after a
/// Ctrl-C.
[[nodiscard]] AilaTree build_aila_tree(const AilaBuilder& way, const AilaTreeSettings& settings, const Mesh& mesh,
                                       const std::string& label, ProgressBar& bar);

}  // namespace clbvh::tool
