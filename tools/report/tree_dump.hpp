#pragma once

#include <clbvh/core/bvh.hpp>
#include <cstdint>
#include <limits>
#include <string>

namespace clbvh::tool {

/// As deep as the tree goes.
inline constexpr std::uint32_t kAnyDepth = std::numeric_limits<std::uint32_t>::max();

/// A tree that read_bvh() or validate() accepts, as JSON with a line for each node of at most `most_depth` edges below
/// the root: parents before children, first child first. Coordinates are the shortest decimals that read back as the
/// same floats, null where they are not finite. docs/dump.md lists the fields.
[[nodiscard]] std::string tree_json(const Bvh& bvh, std::uint32_t most_depth = kAnyDepth);

/// The boxes of the same nodes as OBJ: twelve lines each, in one group a depth, "depth_0" and so on. Throws
/// Error(invalid_input) naming the first node whose box is not finite.
[[nodiscard]] std::string tree_obj(const Bvh& bvh, std::uint32_t most_depth = kAnyDepth);

}  // namespace clbvh::tool
