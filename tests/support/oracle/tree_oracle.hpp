#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "clbvh/options.hpp"
#include "support/oracle/morton_oracle.hpp"

namespace clbvh::test {

/// How a cluster compares its candidates.
enum class Comparison {
    exact,   ///< By distance, then by i ^ j.
    packed,  ///< By the 32-bit key of PLOC++, whose lowest bits of distance give way to those of i ^ j.
};

/// A tree, and how the clustering came about.
struct OracleTree {
    Bvh bvh;
    std::vector<std::uint32_t> clusters_per_iteration;  ///< Of the clustering that ends at the root.
};

/// A tree over the primitives of `order` whose nodes are still to be filled in: two for each leaf.
[[nodiscard]] OracleTree empty_tree(const MortonOrder& order);

/// Where the right part of the Morton range [begin, end) of at least two positions begins: where the highest bit that
/// differs within it turns to one. Bits of the position follow those of the code.
[[nodiscard]] std::uint32_t split_position(const std::vector<std::uint64_t>& codes, std::uint32_t begin,
                                           std::uint32_t end);

/// PLOC over the whole order: the tree of `ploc` and, with its own comparison, of `plocpp`.
[[nodiscard]] OracleTree ploc_tree(const MortonOrder& order, std::uint32_t radius, Comparison comparison);

/// PLOC within each of at least `range_count` ranges (where they can be split so far), then over what is left of them.
[[nodiscard]] OracleTree two_level_tree(const MortonOrder& order, std::uint32_t radius, Comparison comparison,
                                        std::uint32_t range_count);

/// The tree of the codes' common prefixes.
[[nodiscard]] OracleTree lbvh_tree(const MortonOrder& order);
/// The same with the top that the host builds; by the library's own functions, which have tests of their own.
[[nodiscard]] OracleTree hlbvh_tree(const MortonOrder& order);

/// The tree that the builder of this id documents for these options. Options of zero for "chosen" are not resolved:
/// the two-level builder needs its range_count.
[[nodiscard]] OracleTree oracle_tree(std::string_view builder_id, const MortonOrder& order,
                                     const BuildOptions& options);

}  // namespace clbvh::test
