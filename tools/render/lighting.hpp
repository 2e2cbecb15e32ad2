#pragma once

#include <clbvh/core/mesh.hpp>
#include <clbvh/core/ray.hpp>
#include <clbvh/eval/camera.hpp>
#include <limits>
#include <optional>
#include <vector>

#include "measure/ray_engine.hpp"

namespace clbvh::tool {

/// A ball of light; it casts soft shadows, and rays do not see it.
struct Lamp {
    Vec3 centre;
    float radius = 0.0f;
    float intensity = 0.0f;  ///< Light by the square of the distance.
};

/// The lights of a scene: a sky, a sun and lamps.
struct Lighting {
    Vec3 up{0.0f, 1.0f, 0.0f};
    float sunny_share = 1.0f;     ///< About how much of what is seen the sun reaches.
    std::optional<Vec3> to_sun;   ///< Of length 1.
    std::vector<Lamp> lamps;      ///< All alike.
    std::optional<float> ground;  ///< The height, along `up`, of a ground that is not part of the mesh.
    float ground_extent = 0.0f;   ///< How far from the camera's target the ground fades into the sky.

    /// Light from the sky in a direction of length 1.
    [[nodiscard]] Vec3 sky(const Vec3& direction) const;
};

/// Light of the sun on a surface at right angles to it.
inline constexpr Vec3 kSunlight{7.2f, 6.6f, 5.6f};
/// Radius of the sun's disc at distance 1: larger than the real one's, for softer shadows.
inline constexpr float kSunRadius = 0.02f;
inline constexpr Vec3 kLamplight{1.0f, 0.93f, 0.82f};
/// How far rays reach that nothing ends.
inline constexpr float kEndless = std::numeric_limits<float>::infinity();

/// Chooses what suits the view. Where most of what the camera sees is open to the sky: the sun over the viewer's left
/// shoulder, and a ground below the mesh. Indoors: a sun that shines in, where one can, and lamps below the ceiling.
[[nodiscard]] Lighting fitting_lighting(const Mesh& mesh, const Camera& camera, RayEngine& engine);

}  // namespace clbvh::tool
