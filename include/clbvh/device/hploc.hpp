#pragma once

#include <cstdint>

namespace clbvh {

/// hploc: the clusters of every node of the Morton tree, reduced bottom-up in one pass.
///
/// Benthin, Meister, Barczak, Mehalwal, Tsakok, Kensler 2024, "H-PLOC: Hierarchical parallel locally-ordered clustering
/// for bounding volume hierarchy construction". The defaults give trees as good as PLOC's; docs/builders/hploc.md has
/// what is faster in the lane shape.
struct HplocConfig {
    std::uint32_t search_radius = 0;   ///< Clusters of a node that each is compared with to each side, 1 to 31, as the
                                       ///< paper has it; 0: with every other.
    std::uint32_t cluster_limit = 16;  ///< Clusters that a node of the Morton tree keeps, 8 or 16.
    std::uint32_t small_range = 1;     ///< Nodes of up to so many leaves keep small_limit instead, 1 (none) to 2^30.
    std::uint32_t small_limit = 8;     ///< Clusters that a small node keeps, 1 to 8.
    bool merge_pairs = true;           ///< Two leaves that share a node of the Morton tree merge at once.
    std::uint32_t leaf_size = 1;  ///< The largest nodes of the Morton tree with at most so many primitives, 1 to 8,
                                  ///< are the leaves that are clustered.
};

}  // namespace clbvh
