#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "clbvh/core/mesh.hpp"
#include "clbvh/core/ray.hpp"
#include "clbvh/export.h"

namespace clbvh {

class Tracer;

/// A function that finds the first hit of each ray: hits[i] is that of rays[i]. Any tracer can stand behind it.
using ClosestHits = std::function<void(std::span<const Ray> rays, std::span<Hit> hits)>;

/// Asks `tracer`, which has to outlive the result.
[[nodiscard]] CLBVH_EVAL_API ClosestHits closest_hits_of(const Tracer& tracer);

/// A pinhole camera.
struct Camera {
    Vec3 eye;
    Vec3 target{0.0f, 0.0f, -1.0f};
    Vec3 up{0.0f, 1.0f, 0.0f};    ///< The direction that is up in the picture, roughly.
    float field_of_view = 45.0f;  ///< From the picture's lower to its upper edge, in degrees, 1 to 170.

    friend constexpr bool operator==(const Camera&, const Camera&) = default;
};

/// The rays of a camera through a picture.
class CLBVH_EVAL_API CameraRays {
public:
    /// `aspect` is the picture's width over its height. Throws Error(invalid_input) where the camera has a coordinate
    /// that is not finite, the target is at the eye, or the field of view or the aspect is out of its range. An `up`
    /// along the line of sight is replaced by another axis.
    CameraRays(const Camera& camera, float aspect);

    /// The ray through (x, y): (0, 0) is the picture's upper left corner, (1, 1) its lower right one. Its direction has
    /// length 1.
    [[nodiscard]] Ray at(float x, float y) const noexcept;

private:
    Vec3 eye_;
    Vec3 forward_;
    Vec3 right_;  // from the picture's centre to its right edge
    Vec3 down_;   // from the picture's centre to its lower edge
};

/// The camera in "ex,ey,ez,tx,ty,tz" or "ex,ey,ez,tx,ty,tz,fov": eye, target and field of view. `up` is as given.
/// Throws Error(invalid_input) that names the text.
[[nodiscard]] CLBVH_EVAL_API Camera parse_camera(std::string_view text, const Vec3& up);
/// "ex,ey,ez,tx,ty,tz,fov", from which parse_camera reads the same camera, but for `up`.
[[nodiscard]] CLBVH_EVAL_API std::string to_string(const Camera& camera);

/// The axis in "x", "y", "z", "-x", "-y" or "-z". Throws Error(invalid_input) that names the text.
[[nodiscard]] CLBVH_EVAL_API Vec3 parse_axis(std::string_view text);

/// Which axis of the mesh points up, y or z: z where half again as much of the surface faces along z as along y (a plan
/// with buildings on it), or where most of it faces along the axes (rooms, buildings) and the mesh is less than 0.7
/// times as long along z as along y; else y.
[[nodiscard]] CLBVH_EVAL_API Vec3 guess_up(const MeshView& mesh);

/// A view of the scene that a person might choose, the same on every run: from the inside where the detail is closed
/// around, as in a room; else from outside, a little from above. Detail is where nearly all triangles are, whatever
/// their size. Some 240,000 rays are traced to find it. An empty mesh is
/// looked at from (0, 0, 1). Throws what `trace` throws.
[[nodiscard]] CLBVH_EVAL_API Camera fit_camera(const MeshView& mesh, const Vec3& up, const ClosestHits& trace);

}  // namespace clbvh
