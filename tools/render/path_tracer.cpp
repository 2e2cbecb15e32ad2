#include "render/path_tracer.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <clbvh/core/vector.hpp>
#include <clbvh/eval/surface.hpp>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <utility>

#include "render/colour.hpp"
#include "render/light_sample.hpp"
#include "render/sample_sequence.hpp"

namespace clbvh::tool {
namespace {

constexpr std::uint32_t kMostBounces = 5;
constexpr std::uint32_t kRouletteFrom = 2;
constexpr float kBrightest = 12.0f;  // of one path: a rare bright one would be a spot
constexpr Vec3 kGroundAlbedo{0.50f, 0.48f, 0.45f};

/// A path under way.
struct Path {
    Ray ray;
    Vec3 throughput{1.0f, 1.0f, 1.0f};
    std::uint32_t pixel = 0;
};

/// A ray to a light, and what the light adds to the pixel if nothing is between.
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
    Vec3 own_colour{1.0f, 1.0f, 1.0f};  ///< The mesh's part of the albedo.
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
        first_.resize(rays.size());
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
    /// First hit of the pixel's path; a normal of zeros where that was the sky.
    [[nodiscard]] const Surface& first_surface(std::size_t pixel) const { return first_[pixel]; }

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
            if (bounce == 0) first_[paths_[i].pixel] = *surface;
            SampleSequence random(settings_.seed + std::uint64_t{0x10001} * (bounce + 1), paths_[i].pixel, sample_);
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

    /// Finds the path's next hit; where that is the sky, takes its light.
    std::optional<Surface> surface_at(const Path& path, const Hit& hit, std::uint32_t bounce) {
        const float ground = distance_to_ground(path.ray);
        if (hit && hit.t <= ground) {
            const SurfacePoint point = surface_point(mesh_, path.ray, hit);
            const Vec3 smooth = look_.shading_normal(hit, point.normal);
            const Vec3 albedo = look_.albedo(hit, point.normal);
            return Surface{point.position, point.normal, smooth, albedo, albedo};
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

    /// A ray to one of the lights; its light is zero where none reaches the surface.
    [[nodiscard]] LightRay light_ray(const Path& path, const Surface& surface, SampleSequence& random) const {
        LightRay result;
        const auto sample = sample_light(lighting_, surface.position, surface.shading_normal, random);
        if (!sample || dot(surface.normal, sample->direction) <= 0.0f) return result;
        const float cosine = std::max(0.0f, dot(surface.shading_normal, sample->direction));
        const Vec3 sent = modulated(path.throughput, modulated(surface.albedo, sample->light));
        result.ray = {surface.position, 0.0f, sample->direction, sample->distance};
        result.light = sent * (cosine / std::numbers::pi_v<float>);
        result.pixel = path.pixel;
        return result;
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
    std::vector<Surface> first_;
    std::vector<Path> paths_;
    std::vector<LightRay> light_rays_;
    std::vector<Ray> rays_;
    std::vector<Hit> hits_;
    std::vector<std::uint8_t> is_hit_;
};

/// Sums of the samples of all pixels.
class SampleSums {
public:
    SampleSums(std::uint32_t width, std::uint32_t height)
        : picture_(width, height), squares_(picture_.variance.size()), surfaces_(squares_.size()) {}

    void add(const Wave& wave) {
        tbb::parallel_for(std::size_t{0}, squares_.size(), [&](std::size_t i) {
            const Vec3 light = wave.light(i);
            const Surface& first = wave.first_surface(i);
            picture_.light.pixels()[i] = picture_.light.pixels()[i] + light;
            picture_.albedo.pixels()[i] = picture_.albedo.pixels()[i] + first.own_colour;
            picture_.normal.pixels()[i] = picture_.normal.pixels()[i] + first.shading_normal;
            picture_.position.pixels()[i] = picture_.position.pixels()[i] + first.position;
            const float bright =
                brightness({light.x / first.own_colour.x, light.y / first.own_colour.y, light.z / first.own_colour.z});
            picture_.variance[i] += bright;
            squares_[i] += bright * bright;
            if (first.normal != Vec3{}) ++surfaces_[i];
        });
    }

    /// Mean values, and the variance of the mean.
    [[nodiscard]] LitPicture means(std::uint32_t samples) {
        const auto count = static_cast<float>(samples);
        for (std::size_t i = 0; i < squares_.size(); ++i) {
            for (Picture* sum : {&picture_.light, &picture_.albedo})
                sum->pixels()[i] = sum->pixels()[i] * (1.0f / count);
            picture_.normal.pixels()[i] = normalized(picture_.normal.pixels()[i]);
            const float seen = std::max(1.0f, static_cast<float>(surfaces_[i]));
            picture_.position.pixels()[i] = picture_.position.pixels()[i] * (1.0f / seen);
            picture_.is_surface[i] = surfaces_[i] > 0 ? 1 : 0;
            const float mean = picture_.variance[i] / count;
            picture_.variance[i] = std::max(0.0f, squares_[i] / count - mean * mean) / count;
        }
        return std::move(picture_);
    }

private:
    LitPicture picture_;
    std::vector<float> squares_;
    std::vector<std::uint32_t> surfaces_;  // samples that met one
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
    SampleSums sums(settings.width, settings.height);
    for (std::uint32_t sample = 0; sample < settings.samples; ++sample) {
        Wave wave(mesh, look, lighting, camera, engine, settings, sample);
        wave.run([&](double part) { settings.progress((sample + part) / static_cast<double>(settings.samples)); });
        sums.add(wave);
    }
    return sums.means(settings.samples);
}

}  // namespace clbvh::tool
