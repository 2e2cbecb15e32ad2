#pragma once

#include <cstdint>

#include "clbvh/core/bvh.hpp"
#include "clbvh/export.h"
#include "clbvh/optimize/budget.hpp"

namespace clbvh {

/// Hill climbing by tree rotations: every inner node, children first, exchanges a child with a grandchild on the other
/// side, or two grandchildren, whichever saves most; again and again, until no exchange saves anything.
///
/// Kensler 2008, "Tree Rotations for Improving Bounding Volume Hierarchies", sections 2 and 3.
struct RotateConfig {
    /// Ends when a pass lowers the summed area of the inner nodes by less than this part of it, 0 to 1.
    float least_gain = 0.0f;
    OptimizeBudget budget;  ///< At most 1000 passes unless it says otherwise.
};

/// Works in the calling task arena of oneTBB; the tree is the same on any number of threads. It takes every tree that
/// validate() accepts; leaves stay as they are, and the SAH cost never rises. In the end siblings are ordered along
/// the axis on which their boxes are farthest apart, or else overlap least, the lower one first (section 5). Throws
/// Error(invalid_input) where a field of `config` is out of its range, naming it; Error(out_of_memory).
[[nodiscard]] CLBVH_API Bvh rotate(Bvh tree, const RotateConfig& config = {}, OptimizeStats* stats = nullptr);

/// Simulated annealing by tree rotations: while it is hot, exchanges that cost something are made too, at random.
///
/// Kensler 2008, section 4: passes i = 0 .. length - 1 at temperature
/// max(0, -sin(i 2 pi / period)) (length - i) hottest / length, then passes at 0 until nothing is found. The paper does
/// not say what its costs are; those of the conference room there (402) and in Aila, Karras, Laine 2013 (46.5, where
/// C_inner is 1.2) make its C_inner about 10.
struct AnnealConfig {
    std::uint32_t length = 1250;  ///< N: passes with a temperature, 1 to 10^6.
    float period = 50.0f;         ///< f: passes from one heating to the next, above 0.
    float hottest = 1.5f;    ///< h, 0 to 100, with C_inner = 10; the paper uses 0.8 to 2.2, depending on the scene.
    std::uint64_t seed = 1;  ///< Of the random numbers that pick exchanges, any value: another gives another tree.
    OptimizeBudget budget;   ///< Where it sets no number of passes: all of them, and at most 1000 to cool off.
};

/// As rotate(); returns the best tree that a pass ended with, so that the SAH cost never rises. The same seed gives the
/// same tree on any number of threads: the random numbers belong to nodes and passes.
[[nodiscard]] CLBVH_API Bvh anneal(Bvh tree, const AnnealConfig& config = {}, OptimizeStats* stats = nullptr);

}  // namespace clbvh
