#pragma once

#include <cstdint>
#include <vector>

#include "clbvh/core/mesh.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// Splits the triangles whose boxes are mostly empty, before any builder sees them.
///
/// Dammertz, Keller 2008, "The edge volume heuristic - robust triangle subdivision for improved BVH performance". An
/// edge is as bad as its own box is large: while the worst edge of a triangle has a box above scene volume / 2^level,
/// the triangle is split at the middle of that edge. O(parts) time. In a scene without volume no edge has one either,
/// so nothing is split.
struct PresplitConfig {
    std::uint32_t level = 14;      ///< Edges up to scene volume / 2^level are left alone, 1 to 40.
    float triangle_budget = 4.0f;  ///< Most parts, as a multiple of the triangles, 1 to 64. Where `level` needs more,
                                   ///< the highest level that does not is taken for the whole mesh.
};

/// A mesh, and where its triangles come from.
struct PresplitMesh {
    Mesh mesh;                          ///< The parts of a triangle follow each other, wound as it is.
    std::vector<std::uint32_t> source;  ///< The triangle that each part is a part of; ascending.
};

/// Splits `mesh`, on the threads of the calling task arena of oneTBB, the same on any number of them. Watertight:
/// whether and where an edge is split depends on nothing but its two end points, so that both triangles at an edge get
/// the same points. Inactive triangles stay as they are. New corners are rounded to float32; a builder that must lose
/// no point of a triangle takes BuildOptions::presplit_level instead, which rounds the parts' boxes outwards. Throws
/// what check_mesh throws; Error(invalid_input) where a field of `config` is out of its range, naming it.
[[nodiscard]] CLBVH_API PresplitMesh presplit(const MeshView& mesh, const PresplitConfig& config = {});

}  // namespace clbvh
