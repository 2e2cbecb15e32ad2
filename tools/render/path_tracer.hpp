#pragma once

#include <clbvh/core/mesh.hpp>
#include <clbvh/eval/camera.hpp>
#include <cstdint>
#include <functional>
#include <vector>

#include "measure/ray_engine.hpp"
#include "render/denoise.hpp"
#include "render/lighting.hpp"
#include "render/picture.hpp"
#include "render/surface_look.hpp"

namespace clbvh::tool {

/// Arguments of all kinds of pictures.
struct RenderSettings {
    std::uint32_t width = 1280;
    std::uint32_t height = 720;
    std::uint32_t samples = 16;  ///< Of a pixel.
    std::uint64_t seed = 1;
    bool denoised = true;                           ///< Where that is possible: paths of at least 4 samples.
    std::function<void(double fraction)> progress;  ///< Called between batches of rays; may throw.
};

/// Paths of up to five rays through a scene of diffuse surfaces, with a ray to a light from every surface (next event
/// estimation) and Russian roulette from the third surface on. One path of each pixel at a time: all rays of a bounce
/// are one batch for `engine`.
[[nodiscard]] LitPicture trace_paths(const Mesh& mesh, const SurfaceLook& look, const Lighting& lighting,
                                     const Camera& camera, RayEngine& engine, const RenderSettings& settings);

/// The rays of one sample of every pixel.
[[nodiscard]] std::vector<Ray> pixel_rays(const Camera& camera, const RenderSettings& settings, std::uint32_t sample);

}  // namespace clbvh::tool
