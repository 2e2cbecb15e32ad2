#pragma once

#include <clbvh/core/mesh.hpp>
#include <clbvh/eval/camera.hpp>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "measure/ray_engine.hpp"
#include "render/path_tracer.hpp"
#include "render/picture.hpp"

namespace clbvh::tool {

/// The kinds of pictures.
enum class RenderMode : std::uint8_t {
    normal,       ///< The direction of surfaces as colours, under a lamp at the camera.
    ao,           ///< Ambient occlusion: how open surfaces are to what is near.
    path,         ///< Path-traced.
    heat_nodes,   ///< Nodes that each primary ray visits.
    heat_leaves,  ///< Leaves that each primary ray would visit if nothing ended it.
};

/// "normal", "ao", "path", "heat-nodes", "heat-leaves"
[[nodiscard]] std::string_view to_string(RenderMode mode);
[[nodiscard]] std::optional<RenderMode> render_mode_from(std::string_view name);
/// Default samples of a pixel.
[[nodiscard]] std::uint32_t usual_samples(RenderMode mode);

/// True for pictures of what a tree costs; all others do not depend on the tree.
[[nodiscard]] constexpr bool shows_heat(RenderMode mode) {
    return mode == RenderMode::heat_nodes || mode == RenderMode::heat_leaves;
}

/// The picture in a mode that shows no heat, 0 to 1 in sRGB.
[[nodiscard]] Picture render(RenderMode mode, const Mesh& mesh, const Camera& camera, RayEngine& engine,
                             const RenderSettings& settings);

/// The visits at each pixel in a mode that shows heat, for heat_map().
[[nodiscard]] std::vector<float> measure_heat(RenderMode mode, const Camera& camera, RayEngine& engine,
                                              const RenderSettings& settings);

}  // namespace clbvh::tool
