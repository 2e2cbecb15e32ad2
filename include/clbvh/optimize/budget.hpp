#pragma once

#include <cstdint>

#include "clbvh/core/build_stats.hpp"

namespace clbvh {

/// When an optimiser stops at the latest. Each stops by itself too, when it finds nothing more to improve. All throw
/// Error(invalid_input) where `milliseconds` is negative or not a number.
struct OptimizeBudget {
    std::uint32_t passes = 0;   ///< Most passes over the tree; 0: the optimiser's own limit.
    double milliseconds = 0.0;  ///< No new piece of work is begun after so much wall time, 0 or more; 0: no limit. A
                                ///< tree that ran out of time depends on the machine's speed.
    ProgressCallback progress;  ///< Called on the calling thread with the optimiser's name as the stage. Where it
                                ///< returns false the optimiser stops, and returns the tree as improved so far.
};

/// Statistics of an optimiser's run.
struct OptimizeStats {
    std::uint32_t passes = 0;   ///< Passes that were finished.
    std::uint64_t changes = 0;  ///< Nodes moved, pairs exchanged or treelets restructured. Each lowered
                                ///< the cost, but for those of annealing, which also raises it.
    double milliseconds = 0.0;  ///< Wall time.
    bool is_cancelled = false;  ///< The progress callback asked to stop.
};

}  // namespace clbvh
