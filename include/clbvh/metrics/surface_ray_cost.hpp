#pragma once

#include <cstdint>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"
#include "clbvh/export.h"
#include "clbvh/metrics/lcv.hpp"
#include "clbvh/metrics/sah.hpp"

namespace clbvh {

/// What rays from the surfaces of a scene cost in a tree over it.
struct SurfaceRayCost {
    double cost = 0.0;  ///< Of a ray, in the mean: SahCosts::inner for each inner node that it visits on the way to its
                        ///< closest hit, SahCosts::primitive for each triangle that it is tested against.
    MeanCounts counts;  ///< What it visits.
    std::uint32_t ray_count = 0;  ///< Rays that were traced.
};

/// Rays of a sample, 1 to 2^24, and as many as tell trees apart by a percent or two.
inline constexpr std::uint32_t kMostSurfaceRays = 1U << 24;
inline constexpr std::uint32_t kSurfaceRays = 10000;

/// What a ray costs that begins on a surface, in any direction, and ends at its closest hit: what rays of a renderer do
/// after their first bounce. The SAH cost is about lines from outside through the whole box; where little of the box
/// has anything in it, because of one far triangle say, that tells nothing of rays among the rest.
///
/// The rays are the same for all trees over a mesh: a sequence of low discrepancy (Roberts 2018, "The Unreasonable
/// Effectiveness of Quasirandom Sequences", R5) chooses where they begin and where they go, half of them from triangles
/// that are all as likely, half by area. Inactive triangles and those without area send none. The tree is followed two
/// children at a time, the nearer one first, as BinaryTracer does; the triangle that a ray begins on does not end it,
/// and it begins 2^-18 of its largest coordinate away from there.
///
/// In the calling task arena of oneTBB, the same bits on any number of threads; tens of milliseconds for 10,000 rays
/// and a million triangles. 0 where no ray was traced. Throws Error(invalid_input) for a negative or non-finite cost, a
/// number of rays out of range, for a mesh that check_mesh refuses and for a tree that was not built over this mesh.
[[nodiscard]] CLBVH_API SurfaceRayCost surface_ray_cost(const Bvh& bvh, const MeshView& mesh,
                                                        std::uint32_t ray_count = kSurfaceRays,
                                                        const SahCosts& costs = {});

}  // namespace clbvh
