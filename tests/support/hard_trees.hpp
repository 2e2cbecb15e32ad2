#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"

namespace clbvh::test {

/// Ids and corners of a leaf.
using LeafContent = std::pair<std::vector<std::uint32_t>, std::array<float, 6>>;
/// Those of all leaves, in order.
[[nodiscard]] std::vector<LeafContent> leaves_of(const Bvh& tree);

/// A tree whose inner nodes form a chain: node k has triangle k on one side and all that follow on the other.
[[nodiscard]] Bvh chain_tree(const Mesh& mesh);

/// The same tree in twice as many slots; what lies between those in use looks like nodes.
[[nodiscard]] Bvh with_strays(const Bvh& tree);

/// Triangles whose corners lie on a line, so that no box has an area.
[[nodiscard]] Mesh line_of_points(std::uint32_t count);

/// Such a line's points moved on: to a curve, whose boxes have areas, to the line, to one point, to the curve, and to
/// the line.
[[nodiscard]] std::array<Mesh, 5> flat_and_other_frames(const Mesh& line);

}  // namespace clbvh::test
