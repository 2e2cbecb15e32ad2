#pragma once

#include <clbvh/core/mesh.hpp>
#include <clbvh/options.hpp>

#include "measure/first_ray.hpp"

namespace clbvh::tool {

/// Scenes of Embree's over a mesh that passes check_mesh and outlives them, at low, medium and high build quality:
/// embree-low, embree-medium and embree-high. Timed is all from the mesh's arrays on: geometry, scene, commit and one
/// ray; Embree's device is kept from run to run, as other contestants keep what they make once. Rays are traced one by
/// one with rtcIntersect1 and rtcOccluded1, in scenes as they are by default, which are not robust. Of `options` the
/// thread count is read. Throws as check_embree_peers does.
[[nodiscard]] FirstRayEntrants make_embree_scenes(const BuildOptions& options, const Mesh& mesh);

}  // namespace clbvh::tool
