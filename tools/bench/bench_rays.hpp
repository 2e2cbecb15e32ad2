#pragma once

#include <clbvh/core/mesh.hpp>
#include <clbvh/eval/camera.hpp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "measure/build_result.hpp"
#include "measure/contestant.hpp"
#include "measure/rounds.hpp"

namespace clbvh::tool {

/// Traces some 2^18 diffuse rays of seed 1 through the last tree of each entrant, on `threads` threads of the host (0:
/// all), and fills in BuildResult::rays; results[i] is of entrants[i]. Entrants without a readable, valid tree are left
/// out, and all where the camera sees nothing.
void bench_rays(std::span<BuildResult> results, std::span<const std::unique_ptr<TreeContestant>> entrants,
                const Mesh& mesh, const Camera& camera, std::size_t runs, std::uint32_t threads,
                RoundsProgress& progress);

}  // namespace clbvh::tool
