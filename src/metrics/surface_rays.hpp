#pragma once

#include <cstdint>
#include <span>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"
#include "clbvh/metrics/surface_ray_cost.hpp"

namespace clbvh {

/// surface_ray_cost of a tree that is known to be one over this mesh, with arguments that are in range.
[[nodiscard]] SurfaceRayCost trace_surface_rays(std::span<const Node> nodes,
                                                std::span<const std::uint32_t> primitive_ids, const MeshView& mesh,
                                                std::uint32_t ray_count, const SahCosts& costs);

}  // namespace clbvh
