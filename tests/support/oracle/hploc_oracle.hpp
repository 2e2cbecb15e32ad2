#pragma once

#include <cstdint>

#include "support/oracle/tree_oracle.hpp"

namespace clbvh::test {

/// H-PLOC with every choice made.
struct HplocOracleOptions {
    std::uint32_t cluster_limit = 16;  ///< Most clusters that a node of the Morton tree keeps, up to 16.
    std::uint32_t small_range = 0;     ///< Nodes of up to so many primitives keep `small_limit` clusters instead.
    std::uint32_t small_limit = 8;     ///< At most cluster_limit.
    bool merge_pairs = true;           ///< A node of two primitives becomes one cluster.
    std::uint32_t window = 0;          ///< Neighbours searched to each side, up to 31; 0: all of the node.
};

/// The choices that these options of the builder hploc stand for.
[[nodiscard]] HplocOracleOptions hploc_oracle_options(const BuildOptions& options);

/// The tree of H-PLOC: every node of the Morton tree, bottom-up, joins its children's lists of clusters, and reduces
/// them by rounds of mutual nearest neighbours where there are more than it keeps; the root keeps one.
[[nodiscard]] OracleTree hploc_tree(const MortonOrder& order, const HplocOracleOptions& options = {});

}  // namespace clbvh::test
