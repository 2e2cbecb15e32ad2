#pragma once

#include "clbvh/core/mesh.hpp"
#include "clbvh/core/ray.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// Where a ray met a triangle, ready to send rays on from.
struct SurfacePoint {
    Vec3 position;  ///< A little above the surface, on the side that the ray came from.
    Vec3 normal;    ///< The triangle's own, of length 1, towards that side.
};

/// The point that `hit`, of `ray` with a triangle of `mesh`, is at.
///
/// The point is interpolated on the triangle, which errs by a few units in the last place of the vertices' coordinates
/// however far the ray came from, and moved along the normal by 2^-18 of the largest of those coordinates, some 64
/// units: a ray that leaves it on the normal's side does not meet the same triangle again. (The idea is that of
/// Waechter and Binder, "A Fast and Robust Method for Avoiding Self-Intersection", Ray Tracing Gems 2019, chapter 6;
/// relative to the coordinates at hand, it needs no constant for small ones.)
[[nodiscard]] CLBVH_EVAL_API SurfacePoint surface_point(const MeshView& mesh, const Ray& ray, const Hit& hit) noexcept;

/// The direction of the hemisphere around `normal` that lies above the point (x, y) of the unit disc: distributed as
/// the cosine with the normal where (x, y) is uniform (Malley's method). `normal` has length 1, and so has the result.
[[nodiscard]] CLBVH_EVAL_API Vec3 cosine_direction(const Vec3& normal, float x, float y) noexcept;

}  // namespace clbvh
