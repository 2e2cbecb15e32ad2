#pragma once

#include <clbvh/core/mesh.hpp>
#include <clbvh/eval/camera.hpp>
#include <string_view>
#include <vector>

#include "bench/bench_scene.hpp"
#include "cli/progress_bar.hpp"
#include "measure/first_ray.hpp"

namespace clbvh::tool {

/// For each builder of the settings, and for Embree's scenes where they name peers, in the same rounds: the way from
/// the mesh's arrays to an answered ray (Builder::build_layout into memory that is kept, and a Tracer that borrows it);
/// then some 2^18 primary rays from the camera, and as many diffuse ones, on one thread.
[[nodiscard]] std::vector<FirstRayResult> first_ray_scene(const BenchSettings& settings, std::string_view scene,
                                                          const Mesh& mesh, const Camera& camera, ProgressBar& bar);

}  // namespace clbvh::tool
