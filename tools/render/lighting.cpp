#include "render/lighting.hpp"

#include <algorithm>
#include <array>
#include <clbvh/core/vector.hpp>
#include <clbvh/eval/ray_sets.hpp>
#include <clbvh/eval/surface.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>

namespace clbvh::tool {
namespace {

/// The camera's view as a small picture.
struct SeenPoints {
    std::vector<SurfacePoint> points;
    std::vector<Ray> rays;
};

SeenPoints look(const Mesh& mesh, const Camera& camera, RayEngine& engine) {
    const std::vector<Ray> rays = primary_rays(camera, 48, 27, 1);
    std::vector<Hit> hits(rays.size());
    engine.closest(rays, hits, {});
    SeenPoints seen;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        if (!hits[i]) continue;
        seen.points.push_back(surface_point(mesh, rays[i], hits[i]));
        seen.rays.push_back(rays[i]);
    }
    return seen;
}

/// How many of the rays hit nothing, as a part of `of`.
double free_share(std::span<const Ray> rays, std::size_t of, RayEngine& engine) {
    if (of == 0) return 0.0;
    std::vector<std::uint8_t> is_hit(rays.size());
    engine.any(rays, is_hit, {});
    return static_cast<double>(std::ranges::count(is_hit, std::uint8_t{0})) / static_cast<double>(of);
}

/// The part of the points' hemispheres that is open.
double openness(const SeenPoints& seen, RayEngine& engine) {
    constexpr std::array<std::array<float, 2>, 8> places{{{0.3f, 0.1f},
                                                          {-0.2f, 0.4f},
                                                          {-0.4f, -0.3f},
                                                          {0.2f, -0.5f},
                                                          {0.8f, 0.2f},
                                                          {-0.1f, 0.85f},
                                                          {-0.8f, -0.1f},
                                                          {0.3f, -0.8f}}};
    std::vector<Ray> rays;
    for (const SurfacePoint& point : seen.points) {
        for (const auto& [x, y] : places)
            rays.push_back({point.position, 0.0f, cosine_direction(point.normal, x, y), kEndless});
    }
    return free_share(rays, rays.size(), engine);
}

/// Where directions are told by: up, and two at right angles to it and to each other.
struct Compass {
    Vec3 up;
    Vec3 north;
    Vec3 east;

    explicit Compass(const Camera& camera) : up(normalized(camera.up)) {
        const Vec3 ahead = camera.target - camera.eye;
        north = normalized(ahead - up * dot(ahead, up));
        if (north == Vec3{}) north = normalized(cross(up, {0.3f, 0.5f, 0.8f}));
        east = cross(north, up);
    }
    /// `azimuth` from north over east, and the height above the horizon, in radians.
    [[nodiscard]] Vec3 direction(float azimuth, float height) const {
        const Vec3 level = north * std::cos(azimuth) + east * std::sin(azimuth);
        return normalized(level * std::cos(height) + up * std::sin(height));
    }
};

/// Lets the sun shine from where it reaches most of what is seen, if it reaches anything to speak of.
void add_sun_through_windows(Lighting& lighting, const SeenPoints& seen, const Compass& compass, RayEngine& engine) {
    constexpr double worth_having = 0.004;
    double best_share = worth_having;
    for (int i = 0; i < 96; ++i) {
        const float azimuth = static_cast<float>(i) * 2.0f * std::numbers::pi_v<float> * 0.618034f;
        const Vec3 to_sun = compass.direction(azimuth, 0.3f + 0.7f * static_cast<float>(i % 7) / 7.0f);
        std::vector<Ray> rays;
        for (const SurfacePoint& point : seen.points) {
            if (dot(point.normal, to_sun) > 0.0f) rays.push_back({point.position, 0.0f, to_sun, kEndless});
        }
        const double share = free_share(rays, seen.points.size(), engine);
        if (share <= best_share) continue;
        best_share = share;
        lighting.to_sun = to_sun;
        lighting.sunny_share = static_cast<float>(share);
    }
}

/// Below the ceiling over places between the camera and what it sees: they are in the same room.
std::vector<Lamp> lamps_below_ceiling(const SeenPoints& seen, const Vec3& up, float diagonal, RayEngine& engine) {
    constexpr std::size_t count = 5;
    std::vector<Ray> rays;
    for (std::size_t i = 0; i < count && !seen.points.empty(); ++i) {
        const std::size_t pick = (2 * i + 1) * seen.points.size() / (2 * count);
        const Vec3 way = seen.points[pick].position - seen.rays[pick].origin;
        rays.push_back({seen.rays[pick].origin + way * (0.25f + 0.12f * static_cast<float>(i)), 0.0f, up, kEndless});
    }
    std::vector<Hit> hits(rays.size());
    engine.closest(rays, hits, {});
    std::vector<Lamp> lamps;
    const float reach = 0.3f * diagonal;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const float rise = std::min(hits[i].t * 0.8f, 0.35f * diagonal);
        const Lamp lamp{rays[i].origin + up * rise, 0.015f * diagonal, reach * reach};
        lamps.push_back(lamp);
    }
    return lamps;
}

/// The height of the mesh's lowest point.
float lowest(const Mesh& mesh, const Vec3& up) {
    float height = kEndless;
    for (const Triangle& triangle : mesh.triangles) {
        // A comparison with NaN is false.
        for (const std::uint32_t index : triangle)
            height = std::min(height, dot(mesh.vertices[index], up));
    }
    return height;
}

}  // namespace

Vec3 Lighting::sky(const Vec3& direction) const {
    constexpr Vec3 zenith{0.30f, 0.48f, 0.85f};
    constexpr Vec3 horizon{0.86f, 0.90f, 0.95f};
    constexpr Vec3 below{0.42f, 0.40f, 0.38f};
    const float height = dot(direction, up);
    if (height < 0.0f) return horizon + (below - horizon) * std::min(1.0f, -6.0f * height);
    return horizon + (zenith - horizon) * std::sqrt(std::min(1.0f, height));
}

Lighting fitting_lighting(const Mesh& mesh, const Camera& camera, RayEngine& engine) {
    constexpr double open_to_the_sky = 0.25;
    const Compass compass(camera);
    const SeenPoints seen = look(mesh, camera, engine);
    Lighting lighting;
    lighting.up = compass.up;
    if (seen.points.empty() || openness(seen, engine) > open_to_the_sky) {
        lighting.to_sun = compass.direction(-2.2f, 0.85f);
        if (!seen.points.empty()) lighting.ground = lowest(mesh, compass.up);
        lighting.ground_extent = 6.0f * length(camera.target - camera.eye);
        return lighting;
    }
    add_sun_through_windows(lighting, seen, compass, engine);
    // The room is about as large as the way to what is seen.
    std::vector<float> distances;
    for (const SurfacePoint& point : seen.points)
        distances.push_back(length(point.position - camera.eye));
    std::ranges::nth_element(distances, distances.begin() + std::ptrdiff_t(distances.size() / 2));
    const float room = 2.0f * distances[distances.size() / 2];
    lighting.lamps = lamps_below_ceiling(seen, compass.up, room, engine);
    return lighting;
}

}  // namespace clbvh::tool
