#include "clbvh/eval/ray_sets.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "clbvh/core/error.hpp"
#include "clbvh/core/mesh_bounds.hpp"
#include "clbvh/core/vector.hpp"
#include "clbvh/eval/surface.hpp"
#include "core/memory_errors.hpp"
#include "core/own_group.hpp"
#include "core/random.hpp"

namespace clbvh {
namespace {

constexpr double kMostCellsPerRay = 16.0;
constexpr std::uint32_t kDiffuseRaysPerPoint = 64;  // Benthin et al. 2022, section 5.2
constexpr std::uint32_t kAmbientRaysPerPoint = 16;
constexpr float kAmbientLength = 0.1f;  // of the diagonal of the mesh's box
constexpr std::uint32_t kLights = 4;
constexpr double kAspect = 4.0 / 3.0;
constexpr std::uint64_t kMostRays = std::uint64_t{1} << 30;

constexpr std::array<std::pair<RayKind, std::string_view>, 5> kNames{{{RayKind::primary, "primary"},
                                                                      {RayKind::diffuse, "diffuse"},
                                                                      {RayKind::shadow, "shadow"},
                                                                      {RayKind::ambient_occlusion, "ao"},
                                                                      {RayKind::random, "random"}}};

Vec3 random_cosine_direction(const Vec3& normal, Random& random) {
    float x = 0.0f;
    float y = 0.0f;
    do {
        x = random.between(-1.0f, 1.0f);
        y = random.between(-1.0f, 1.0f);
    } while (x * x + y * y >= 1.0f);
    return cosine_direction(normal, x, y);
}

/// Where those of the rays that hit something do.
std::vector<SurfacePoint> surface_points(const MeshView& mesh, const ClosestHits& trace, std::span<const Ray> rays) {
    std::vector<Hit> hits(rays.size());
    trace(rays, hits);
    std::vector<SurfacePoint> points;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        if (hits[i]) points.push_back(surface_point(mesh, rays[i], hits[i]));
    }
    return points;
}

/// From each point `rays_per_point` rays; those of all points take part in one numbering.
std::vector<Ray> hemisphere_rays(std::span<const SurfacePoint> points, std::uint32_t rays_per_point, float t_max,
                                 std::uint64_t seed) {
    std::vector<Ray> rays(points.size() * rays_per_point);
    in_own_group([&] {
        tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t p) {
            for (std::size_t i = p * rays_per_point; i < (p + 1) * rays_per_point; ++i) {
                Random random = Random::stream(seed, i);
                rays[i] = {points[p].position, 0.0f, random_cosine_direction(points[p].normal, random), t_max};
            }
        });
    });
    return rays;
}

float component(const Vec3& v, std::size_t axis) {
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

float& component(Vec3& v, std::size_t axis) {
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

/// The place of a line's entry is chosen face by face: the axis by area, the side by a coin.
class LineSource {
public:
    explicit LineSource(const Aabb& bounds) : bounds_(bounds), size_(bounds.upper - bounds.lower) {
        const std::array<double, 3> size{size_.x, size_.y, size_.z};
        areas_ = {size[1] * size[2], size[2] * size[0], size[0] * size[1]};
        diagonal_ = static_cast<float>(std::sqrt((size[0] * size[0] + size[1] * size[1]) + size[2] * size[2]));
    }

    [[nodiscard]] bool empty() const {
        const bool holds_points = size_.x >= 0.0f && size_.y >= 0.0f && size_.z >= 0.0f;
        return !holds_points || areas_[0] + areas_[1] + areas_[2] == 0.0;
    }

    [[nodiscard]] Ray line(Random& random) const {
        const std::size_t axis = random_axis(random);
        Vec3 place{random.unit() * size_.x, random.unit() * size_.y, random.unit() * size_.z};
        Vec3 inward;
        const bool lower_side = random.below(2) == 0;
        component(place, axis) = lower_side ? 0.0f : component(size_, axis);
        component(inward, axis) = lower_side ? 1.0f : -1.0f;
        const Vec3 direction = random_cosine_direction(inward, random);
        Ray ray;
        ray.origin = (bounds_.lower + place) - diagonal_ * direction;
        ray.direction = direction;
        return ray;
    }

private:
    [[nodiscard]] std::size_t random_axis(Random& random) const {
        const double at = static_cast<double>(random.unit()) * (areas_[0] + areas_[1] + areas_[2]);
        if (at < areas_[0]) return 0;
        return at < areas_[0] + areas_[1] ? 1 : 2;
    }

    Aabb bounds_;
    Vec3 size_;
    std::array<double, 3> areas_{};
    float diagonal_ = 0.0f;
};

bool is_inside(const Aabb& box, const Vec3& p) {
    return p.x >= box.lower.x && p.y >= box.lower.y && p.z >= box.lower.z && p.x <= box.upper.x && p.y <= box.upper.y &&
           p.z <= box.upper.z;
}

/// A grid of the aspect of all sets with about `cells` cells.
std::vector<Ray> primary_grid(const Camera& camera, double cells, std::uint64_t seed) {
    const double width = std::max(1.0, std::round(std::sqrt(cells * kAspect)));
    const double height = std::max(1.0, std::round(cells / width));
    return primary_rays(camera, static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), seed);
}

std::vector<Ray> rays_from(RayKind kind, const MeshView& mesh, const ClosestHits& trace, const Camera& camera,
                           std::span<const Ray> primary, std::uint64_t seed) {
    const Aabb bounds = mesh_bounds(mesh);
    if (kind == RayKind::diffuse) return diffuse_rays(mesh, trace, primary, kDiffuseRaysPerPoint, seed);
    if (kind == RayKind::shadow) return shadow_rays(mesh, trace, primary, random_lights(bounds, camera, kLights, seed));
    const float length = kAmbientLength * clbvh::length(bounds.upper - bounds.lower);
    return ambient_occlusion_rays(mesh, trace, primary, kAmbientRaysPerPoint, length, seed);
}

/// How many rays come of one of the camera's is seen in a small picture first, or in larger ones where the small one
/// shows nothing.
std::vector<Ray> rays_beyond_primary(RayKind kind, const MeshView& mesh, const ClosestHits& trace, const Camera& camera,
                                     const RaySetOptions& options) {
    for (const double pilot_cells : {1024.0, 32768.0, 1048576.0}) {
        const std::vector<Ray> pilot = primary_grid(camera, pilot_cells, options.seed);
        const std::size_t found = rays_from(kind, mesh, trace, camera, pilot, options.seed).size();
        if (found == 0) continue;
        const double rays_per_cell = static_cast<double>(found) / static_cast<double>(pilot.size());
        // Where next to nothing is seen there are fewer rays than asked for, instead of a picture beyond all memory.
        const double cells = std::min(static_cast<double>(options.count) / rays_per_cell,
                                      std::max(kMostCellsPerRay * static_cast<double>(options.count), pilot_cells));
        const std::vector<Ray> primary = primary_grid(camera, cells, options.seed);
        return rays_from(kind, mesh, trace, camera, primary, options.seed);
    }
    return {};
}

}  // namespace

std::string_view to_string(RayKind kind) noexcept {
    return std::ranges::find(kNames, kind, &std::pair<RayKind, std::string_view>::first)->second;
}

std::optional<RayKind> ray_kind_from(std::string_view name) noexcept {
    const auto found = std::ranges::find(kNames, name, &std::pair<RayKind, std::string_view>::second);
    if (found == kNames.end()) return {};
    return found->first;
}

std::vector<Ray> primary_rays(const Camera& camera, std::uint32_t width, std::uint32_t height, std::uint64_t seed) {
    const auto columns = static_cast<float>(width);
    const auto lines = static_cast<float>(height);
    const CameraRays camera_rays(camera, columns / lines);
    std::vector<Ray> rays(std::size_t{width} * height);
    in_own_group([&] {
        tbb::parallel_for(std::uint32_t{0}, height, [&](std::uint32_t y) {
            for (std::uint32_t x = 0; x < width; ++x) {
                const std::size_t i = std::size_t{y} * width + x;
                Random random = Random::stream(seed, i);
                const float across = static_cast<float>(x) + random.unit();
                const float down = static_cast<float>(y) + random.unit();
                rays[i] = camera_rays.at(across / columns, down / lines);
            }
        });
    });
    return rays;
}

std::vector<Ray> diffuse_rays(const MeshView& mesh, const ClosestHits& trace, std::span<const Ray> primary,
                              std::uint32_t rays_per_point, std::uint64_t seed) {
    constexpr float endless = std::numeric_limits<float>::infinity();
    // The numbers of the second bounce are not those of the first.
    const std::uint64_t second_seed = Random(seed).bits();
    std::vector<Ray> rays = hemisphere_rays(surface_points(mesh, trace, primary), rays_per_point, endless, seed);
    const std::vector<Ray> second = hemisphere_rays(surface_points(mesh, trace, rays), 1, endless, second_seed);
    rays.insert(rays.end(), second.begin(), second.end());
    return rays;
}

std::vector<Ray> shadow_rays(const MeshView& mesh, const ClosestHits& trace, std::span<const Ray> primary,
                             std::span<const Vec3> lights) {
    std::vector<Ray> rays;
    for (const SurfacePoint& point : surface_points(mesh, trace, primary)) {
        for (const Vec3& light : lights) {
            const Vec3 way = light - point.position;
            if (dot(way, point.normal) > 0.0f) rays.push_back({point.position, 0.0f, way, 1.0f});
        }
    }
    return rays;
}

std::vector<Vec3> random_lights(const Aabb& bounds, const Camera& camera, std::uint32_t count, std::uint64_t seed) {
    const float growth = is_inside(bounds, camera.eye) ? 0.0f : 1.0f;
    const Vec3 size = bounds.upper - bounds.lower;
    const Vec3 lower = bounds.lower - growth * size;
    const Vec3 upper = bounds.upper + growth * size;
    std::vector<Vec3> lights(count);
    Random random(seed);
    for (Vec3& light : lights) {
        light.x = random.between(lower.x, upper.x);
        light.y = random.between(lower.y, upper.y);
        light.z = random.between(lower.z, upper.z);
    }
    return lights;
}

std::vector<Ray> ambient_occlusion_rays(const MeshView& mesh, const ClosestHits& trace, std::span<const Ray> primary,
                                        std::uint32_t rays_per_point, float length, std::uint64_t seed) {
    return hemisphere_rays(surface_points(mesh, trace, primary), rays_per_point, length, seed);
}

std::vector<Ray> random_lines(const Aabb& bounds, std::uint64_t count, std::uint64_t seed) {
    const LineSource source(bounds);
    if (source.empty()) return {};
    std::vector<Ray> rays(count);
    in_own_group([&] {
        tbb::parallel_for(std::size_t{0}, rays.size(), [&](std::size_t i) {
            Random random = Random::stream(seed, i);
            rays[i] = source.line(random);
        });
    });
    return rays;
}

std::vector<Ray> make_rays(RayKind kind, const MeshView& mesh, const ClosestHits& trace, const Camera& camera,
                           const RaySetOptions& options) {
    if (options.count == 0 || options.count > kMostRays) {
        throw Error(ErrorCode::invalid_input, "the number of rays is " + std::to_string(options.count) +
                                                  "; it has to be 1 to " + std::to_string(kMostRays));
    }
    return with_memory_errors("the rays", [&] {
        if (kind == RayKind::random) return random_lines(mesh_bounds(mesh), options.count, options.seed);
        if (kind == RayKind::primary) return primary_grid(camera, static_cast<double>(options.count), options.seed);
        return rays_beyond_primary(kind, mesh, trace, camera, options);
    });
}

}  // namespace clbvh
