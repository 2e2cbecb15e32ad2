#include "render/render_modes.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <clbvh/core/mesh_bounds.hpp>
#include <clbvh/core/vector.hpp>
#include <clbvh/eval/surface.hpp>
#include <cmath>
#include <cstddef>
#include <utility>

#include "render/lighting.hpp"
#include "render/sample_sequence.hpp"
#include "render/surface_look.hpp"

namespace clbvh::tool {
namespace {

constexpr std::array<std::pair<RenderMode, std::string_view>, 5> kNames{{{RenderMode::normal, "normal"},
                                                                         {RenderMode::ao, "ao"},
                                                                         {RenderMode::path, "path"},
                                                                         {RenderMode::heat_nodes, "heat-nodes"},
                                                                         {RenderMode::heat_leaves, "heat-leaves"}}};
constexpr Vec3 kBackground{0.55f, 0.62f, 0.72f};

/// The mean over the samples of what `shade` adds to the pixels for the primary rays of each sample.
template <typename Shade>
Picture mean_of_samples(const Camera& camera, RayEngine& engine, const RenderSettings& settings, const Shade& shade) {
    Picture picture(settings.width, settings.height);
    std::vector<Hit> hits(picture.pixels().size());
    for (std::uint32_t sample = 0; sample < settings.samples; ++sample) {
        settings.progress(static_cast<double>(sample) / settings.samples);
        const std::vector<Ray> rays = pixel_rays(camera, settings, sample);
        engine.closest(rays, hits, {});
        shade(sample, rays, hits, picture.pixels());
    }
    for (Vec3& pixel : picture.pixels())
        pixel = pixel * (1.0f / static_cast<float>(settings.samples));
    return picture;
}

Picture render_normals(const Mesh& mesh, const Camera& camera, RayEngine& engine, const RenderSettings& settings) {
    const SurfaceLook look(mesh, camera.up);
    return mean_of_samples(camera, engine, settings, [&](std::uint32_t, const auto& rays, const auto& hits, auto& to) {
        tbb::parallel_for(std::size_t{0}, rays.size(), [&](std::size_t i) {
            if (!hits[i]) {
                to[i] = to[i] + kBackground;
                return;
            }
            const Vec3 normal = look.shading_normal(hits[i], surface_point(mesh, rays[i], hits[i]).normal);
            const float headlight = 0.25f + 0.75f * std::max(0.0f, -dot(normal, rays[i].direction));
            to[i] = to[i] + (normal * 0.42f + Vec3{0.58f, 0.58f, 0.58f}) * headlight;
        });
    });
}

Picture render_occlusion(const Mesh& mesh, const Camera& camera, RayEngine& engine, const RenderSettings& settings) {
    constexpr float reach = 0.12f;  // of the box's diagonal
    const Aabb box = mesh_bounds(mesh);
    const float t_max = reach * length(box.upper - box.lower);
    const SurfaceLook look(mesh, camera.up);
    std::vector<Ray> shorts;
    std::vector<std::uint8_t> is_hit;
    return mean_of_samples(
        camera, engine, settings, [&](std::uint32_t sample, const auto& rays, const auto& hits, auto& to) {
            shorts.assign(rays.size(), Ray{});
            tbb::parallel_for(std::size_t{0}, rays.size(), [&](std::size_t i) {
                if (!hits[i]) return;
                const SurfacePoint point = surface_point(mesh, rays[i], hits[i]);
                const auto [x, y] = SampleSequence(settings.seed + 1, i, sample).next_in_disc();
                shorts[i] = {point.position, 0.0f, cosine_direction(look.shading_normal(hits[i], point.normal), x, y),
                             t_max};
            });
            is_hit.resize(rays.size());
            engine.any(shorts, is_hit, {});
            for (std::size_t i = 0; i < rays.size(); ++i) {
                const float open = is_hit[i] != 0 ? 0.0f : 1.0f;
                to[i] = to[i] + (hits[i] ? Vec3{open, open, open} * 0.96f : kBackground);
            }
        });
}

/// 1 for pixels that show the mesh, not the sky or the ground below it.
std::vector<std::uint8_t> shows_mesh(const LitPicture& picture) {
    std::vector<std::uint8_t> result;
    for (const Vec3& albedo : picture.albedo.pixels())
        result.push_back(albedo == Vec3{1.0f, 1.0f, 1.0f} ? 0 : 1);
    return result;
}

Picture render_paths(const Mesh& mesh, const Camera& camera, RayEngine& engine, const RenderSettings& settings) {
    const SurfaceLook look(mesh, camera.up);
    const Lighting lighting = fitting_lighting(mesh, camera, engine);
    LitPicture lit = trace_paths(mesh, look, lighting, camera, engine, settings);
    constexpr std::uint32_t samples_with_variance = 4;
    if (settings.denoised && settings.samples >= samples_with_variance) denoise(lit);
    const float exposure = fitting_exposure(lit.light, shows_mesh(lit));
    for (Vec3& pixel : lit.light.pixels())
        pixel = tone_mapped(pixel, exposure);
    return std::move(lit.light);
}

}  // namespace

std::string_view to_string(RenderMode mode) {
    return std::ranges::find(kNames, mode, &std::pair<RenderMode, std::string_view>::first)->second;
}

std::optional<RenderMode> render_mode_from(std::string_view name) {
    const auto found = std::ranges::find(kNames, name, &std::pair<RenderMode, std::string_view>::second);
    if (found == kNames.end()) return {};
    return found->first;
}

std::uint32_t usual_samples(RenderMode mode) {
    if (shows_heat(mode)) return 1;
    return mode == RenderMode::normal ? 4 : 16;
}

Picture render(RenderMode mode, const Mesh& mesh, const Camera& camera, RayEngine& engine,
               const RenderSettings& settings) {
    if (mode == RenderMode::normal) return render_normals(mesh, camera, engine, settings);
    if (mode == RenderMode::ao) return render_occlusion(mesh, camera, engine, settings);
    return render_paths(mesh, camera, engine, settings);
}

std::vector<float> measure_heat(RenderMode mode, const Camera& camera, RayEngine& engine,
                                const RenderSettings& settings) {
    std::vector<float> values(std::size_t{settings.width} * settings.height);
    std::vector<RayCounts> counts(values.size());
    std::vector<Hit> hits(values.size());
    const float share = 1.0f / static_cast<float>(settings.samples);
    for (std::uint32_t sample = 0; sample < settings.samples; ++sample) {
        settings.progress(static_cast<double>(sample) * static_cast<double>(share));
        const std::vector<Ray> rays = pixel_rays(camera, settings, sample);
        const bool leaves_only = mode == RenderMode::heat_leaves;
        if (leaves_only) {
            engine.visits(rays, counts);
        } else {
            engine.closest(rays, hits, counts);
        }
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] += share * static_cast<float>(counts[i].leaves + (leaves_only ? 0 : counts[i].inner_nodes));
    }
    return values;
}

}  // namespace clbvh::tool
