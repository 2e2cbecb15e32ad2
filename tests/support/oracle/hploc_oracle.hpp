#pragma once

#include "clbvh/device/hploc.hpp"
#include "support/oracle/tree_oracle.hpp"

namespace clbvh::test {

/// The tree of H-PLOC over the largest nodes of the Morton tree with at most leaf_size primitives, which are told by
/// the code of the first one and by their place among the others: every node of the Morton tree, bottom-up, joins its
/// children's lists of clusters, and reduces them by rounds of mutual nearest neighbours where there are more than it
/// keeps; the root keeps one.
[[nodiscard]] OracleTree hploc_tree(const MortonOrder& order, const HplocConfig& options = {});

}  // namespace clbvh::test
