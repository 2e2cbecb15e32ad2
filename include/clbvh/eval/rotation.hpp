#pragma once

#include <array>

#include "clbvh/core/mesh.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// A turn about an axis through the origin, computed in double precision and rounded once: distances between points are
/// kept to the rounding of their coordinates. The turn needs no scene to be known, so that whatever belongs to a scene,
/// as cameras and rays, turns with it.
class CLBVH_EVAL_API Rotation {
public:
    /// Counterclockwise by `degrees` seen from where the axis points to. Throws Error(invalid_input) where the axis is
    /// zero or has a coordinate that is not finite, and where `degrees` is not finite.
    Rotation(const Vec3& axis, double degrees);

    /// The turned point or direction. One with a coordinate that is not finite stays as it is.
    [[nodiscard]] Vec3 operator()(const Vec3& v) const noexcept;

private:
    std::array<std::array<double, 3>, 3> rows_;
};

/// The mesh with every vertex turned, in parallel. Triangles with a NaN stay inactive. A vertex whose coordinates are
/// near kMaxCoordinate may come to lie beyond it, where check_mesh refuses it.
[[nodiscard]] CLBVH_EVAL_API Mesh rotated(Mesh mesh, const Rotation& rotation);

}  // namespace clbvh
