#include "path_tracer.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <clbvh/core/vector.hpp>
#include <clbvh/trace/surface.hpp>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "sample_sequence.hpp"

namespace clbvh::tool {
namespace {

constexpr std::uint32_t kMostBounces = 5;
constexpr std::uint32_t kRouletteFrom = 2;
constexpr float kEndless = std::numeric_limits<float>::infinity();
constexpr float kBrightest = 12.0f;   // of one path: a rare bright one would be a spot
constexpr float kNearestLamp = 4.0f;  // in radii: nearer surfaces get no more light than there
constexpr Vec3 kGroundAlbedo{0.50f, 0.48f, 0.45f};

Vec3 modulated(const Vec3& a, const Vec3& b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}

/// A path under way.
struct Path {
    Ray ray;
    Vec3 throughput{1.0f, 1.0f, 1.0f};
    std::uint32_t pixel = 0;
};

/// What a surface sends a light's way, if nothing is between.
struct LightRay {
    Ray ray;
    Vec3 light;
    std::uint32_t pixel = 0;
};

/// Where a path meets a surface.
struct Surface {
    Vec3 position;
    Vec3 normal;          ///< Of the triangle.
    Vec3 shading_normal;  ///< Of the surface that it stands for.
    Vec3 albedo;
};

/// The paths of one sample of all pixels, from bounce to bounce.
class Wave {
public:
    Wave(const Mesh& mesh, const SurfaceLook& look, const Lighting& lighting, const Camera& camera, RayEngine& engine,
         const RenderSettings& settings, std::uint32_t sample)
        : mesh_(mesh),
          look_(look),
          lighting_(lighting),
          target_(camera.target),
          engine_(engine),
          settings_(settings),
          sample_(sample) {
        const std::vector<Ray> rays = pixel_rays(camera, settings, sample);
        light_.resize(rays.size());
        is_surface_.resize(rays.size());
        paths_.resize(rays.size());
        for (std::uint32_t i = 0; i < rays.size(); ++i)
            paths_[i] = {rays[i], {1.0f, 1.0f, 1.0f}, i};
    }

    void run(const std::function<void(double)>& progress) {
        for (std::uint32_t bounce = 0; bounce < kMostBounces && !paths_.empty(); ++bounce) {
            progress(static_cast<double>(bounce) / kMostBounces);
            meet_surfaces();
            bounce_off(bounce);
            add_light();
        }
    }

    /// Each pixel's light of this sample.
    [[nodiscard]] Vec3 light(std::size_t pixel) const {
        const Vec3& l = light_[pixel];
        return min(l, {kBrightest, kBrightest, kBrightest});
    }
    [[nodiscard]] bool is_surface(std::size_t pixel) const { return is_surface_[pixel] != 0; }

private:
    void meet_surfaces() {
        rays_.resize(paths_.size());
        for (std::size_t i = 0; i < paths_.size(); ++i)
            rays_[i] = paths_[i].ray;
        hits_.resize(rays_.size());
        engine_.closest(rays_, hits_, {});
    }

    /// Makes the light rays and the next rays of all paths; those that end are left out.
    void bounce_off(std::uint32_t bounce) {
        light_rays_.resize(paths_.size());
        tbb::parallel_for(std::size_t{0}, paths_.size(), [&](std::size_t i) {
            light_rays_[i].light = {};
            const std::optional<Surface> surface = surface_at(paths_[i], hits_[i], bounce);
            if (!surface) {
                paths_[i].throughput = {};
                return;
            }
            if (bounce == 0) is_surface_[paths_[i].pixel] = 1;
            SampleSequence random(settings_.seed + 0x10001U * (bounce + 1), paths_[i].pixel, sample_);
            light_rays_[i] = light_ray(paths_[i], *surface, random);
            continue_path(paths_[i], *surface, bounce, random);
        });
        std::erase_if(paths_, [](const Path& path) { return path.throughput == Vec3{}; });
        std::erase_if(light_rays_, [](const LightRay& ray) { return ray.light == Vec3{}; });
    }

    void add_light() {
        rays_.resize(light_rays_.size());
        for (std::size_t i = 0; i < rays_.size(); ++i)
            rays_[i] = light_rays_[i].ray;
        is_hit_.resize(rays_.size());
        engine_.any(rays_, is_hit_, {});
        for (std::size_t i = 0; i < rays_.size(); ++i) {
            Vec3& light = light_[light_rays_[i].pixel];
            if (is_hit_[i] == 0) light = light + light_rays_[i].light;
        }
    }

    /// What the path meets; where that is the sky, takes its light.
    std::optional<Surface> surface_at(const Path& path, const Hit& hit, std::uint32_t bounce) {
        const float ground = distance_to_ground(path.ray);
        if (hit && hit.t <= ground) {
            const SurfacePoint point = surface_point(mesh_, path.ray, hit);
            const Vec3 smooth = look_.shading_normal(hit, point.normal);
            return Surface{point.position, point.normal, smooth, look_.albedo(hit, point.normal)};
        }
        Vec3& light = light_[path.pixel];
        float fade = 1.0f;
        std::optional<Surface> surface;
        if (ground < kEndless) {
            Vec3 position = path.ray.origin + path.ray.direction * ground;
            position = position + lighting_.up * (*lighting_.ground - dot(position, lighting_.up));
            fade = std::min(1.0f, length(position - target_) / lighting_.ground_extent);
            fade = fade * fade;
            surface = Surface{position, lighting_.up, lighting_.up, kGroundAlbedo * (1.0f - fade)};
        }
        // Far off, the ground is the sky's horizon.
        const Vec3 direction = ground < kEndless ? level(path.ray.direction) : path.ray.direction;
        if (fade > 0.0f) light = light + modulated(path.throughput, lighting_.sky(direction)) * fade;
        if (fade >= 1.0f || (bounce > 0 && fade > 0.9f)) return {};
        return surface;
    }

    [[nodiscard]] float distance_to_ground(const Ray& ray) const {
        if (!lighting_.ground) return kEndless;
        const float fall = -dot(ray.direction, lighting_.up);
        const float height = dot(ray.origin, lighting_.up) - *lighting_.ground;
        return fall > 0.0f && height > 0.0f ? height / fall : kEndless;
    }

    [[nodiscard]] Vec3 level(const Vec3& direction) const {
        return normalized(direction - lighting_.up * dot(direction, lighting_.up));
    }

    /// A ray to one of the lights, chosen by what each would give if nothing were between; its light is zero where
    /// none reaches the surface.
    [[nodiscard]] LightRay light_ray(const Path& path, const Surface& surface, SampleSequence& random) const {
        const auto [choice, unused] = random.next();
        const auto [x, y] = random.next_in_disc();
        const std::size_t lights = (lighting_.to_sun ? 1U : 0U) + lighting_.lamps.size();
        float sum = 0.0f;
        for (std::size_t i = 0; i < lights; ++i)
            sum += expected_light(i, surface);
        LightRay result;
        if (sum <= 0.0f) return result;
        std::size_t pick = 0;
        float left = choice * sum;
        while (pick + 1 < lights && left >= expected_light(pick, surface))
            left -= expected_light(pick++, surface);
        const float chance = expected_light(pick, surface) / sum;
        const Arrival arrival =
            pick < lighting_.lamps.size() ? lamp_at(lighting_.lamps[pick], surface, x, y) : sun(x, y);
        const float cosine = dot(surface.shading_normal, arrival.direction);
        if (chance <= 0.0f || cosine <= 0.0f || dot(surface.normal, arrival.direction) <= 0.0f) return result;
        const Vec3 sent = modulated(path.throughput, modulated(surface.albedo, arrival.light));
        result.ray = {surface.position, 0.0f, arrival.direction, arrival.distance};
        result.light = sent * (cosine / (chance * std::numbers::pi_v<float>));
        result.pixel = path.pixel;
        return result;
    }

    /// Light `index` of the lamps and then the sun: about how much of it a surface there can expect.
    [[nodiscard]] float expected_light(std::size_t index, const Surface& surface) const {
        if (index == lighting_.lamps.size()) {
            return lighting_.sunny_share * kSunlight.y * std::max(0.0f, dot(surface.shading_normal, *lighting_.to_sun));
        }
        const Lamp& lamp = lighting_.lamps[index];
        const Vec3 way = lamp.centre - surface.position;
        const float distance = length(way);
        // A ball is seen somewhat beyond the horizon of its centre.
        const float cosine =
            dot(surface.shading_normal, normalized(way)) + lamp.radius / std::max(distance, lamp.radius);
        return lamp.intensity * std::max(0.0f, cosine) / square(std::max(distance, kNearestLamp * lamp.radius));
    }

    static float square(float value) { return value * value; }

    /// What comes from a light.
    struct Arrival {
        Vec3 direction;
        float distance = kEndless;
        Vec3 light;
    };

    [[nodiscard]] Arrival sun(float x, float y) const {
        const Vec3& middle = *lighting_.to_sun;
        const Vec3 above = cosine_direction(middle, x, y);
        const Vec3 in_disc = above - middle * dot(above, middle);
        return {normalized(middle + in_disc * kSunRadius), kEndless, kSunlight};
    }

    /// (x, y) of the disc that the lamp shows to the surface.
    static Arrival lamp_at(const Lamp& lamp, const Surface& surface, float x, float y) {
        const Vec3 back = normalized(surface.position - lamp.centre);
        const Vec3 way = lamp.centre + cosine_direction(back, x, y) * lamp.radius - surface.position;
        const float distance = length(way);
        const float nearest = std::max(distance, kNearestLamp * lamp.radius);
        return {normalized(way), distance, kLamplight * (lamp.intensity / square(nearest))};
    }

    static void continue_path(Path& path, const Surface& surface, std::uint32_t bounce, SampleSequence& random) {
        const auto [x, y] = random.next_in_disc();
        const auto [survival, unused] = random.next();
        path.ray = {surface.position, 0.0f, cosine_direction(surface.shading_normal, x, y), kEndless};
        path.throughput = modulated(path.throughput, surface.albedo);
        const float most = std::max({path.throughput.x, path.throughput.y, path.throughput.z});
        const float chance = bounce < kRouletteFrom ? 1.0f : std::min(1.0f, most);
        const bool ends =
            bounce + 1 == kMostBounces || survival >= chance || dot(path.ray.direction, surface.normal) <= 0.0f;
        path.throughput = ends ? Vec3{} : path.throughput * (1.0f / chance);
    }

    const Mesh& mesh_;
    const SurfaceLook& look_;
    const Lighting& lighting_;
    Vec3 target_;
    RayEngine& engine_;
    const RenderSettings& settings_;
    std::uint32_t sample_;
    std::vector<Vec3> light_;
    std::vector<std::uint8_t> is_surface_;
    std::vector<Path> paths_;
    std::vector<LightRay> light_rays_;
    std::vector<Ray> rays_;
    std::vector<Hit> hits_;
    std::vector<std::uint8_t> is_hit_;
};

}  // namespace

std::vector<Ray> pixel_rays(const Camera& camera, const RenderSettings& settings, std::uint32_t sample) {
    const auto width = static_cast<float>(settings.width);
    const auto height = static_cast<float>(settings.height);
    const CameraRays view(camera, width / height);
    std::vector<Ray> rays(std::size_t{settings.width} * settings.height);
    tbb::parallel_for(std::uint32_t{0}, settings.height, [&](std::uint32_t line) {
        for (std::uint32_t column = 0; column < settings.width; ++column) {
            const std::size_t i = std::size_t{line} * settings.width + column;
            const auto [x, y] = SampleSequence(settings.seed, i, sample).next();
            rays[i] = view.at((static_cast<float>(column) + x) / width, (static_cast<float>(line) + y) / height);
        }
    });
    return rays;
}

LitPicture trace_paths(const Mesh& mesh, const SurfaceLook& look, const Lighting& lighting, const Camera& camera,
                       RayEngine& engine, const RenderSettings& settings) {
    LitPicture picture{{settings.width, settings.height}, {}};
    std::vector<Vec3>& pixels = picture.light.pixels();
    picture.is_surface.resize(pixels.size());
    const float share = 1.0f / static_cast<float>(settings.samples);
    for (std::uint32_t sample = 0; sample < settings.samples; ++sample) {
        Wave wave(mesh, look, lighting, camera, engine, settings, sample);
        wave.run([&](double part) { settings.progress((sample + part) * static_cast<double>(share)); });
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            pixels[i] = pixels[i] + wave.light(i) * share;
            if (wave.is_surface(i)) picture.is_surface[i] = 1;
        }
    }
    return picture;
}

}  // namespace clbvh::tool
