#pragma once

#include <clbvh/core/ray.hpp>
#include <clbvh/eval/ray_sets.hpp>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "measure/ray_engine.hpp"
#include "measure/sample.hpp"

namespace clbvh::tool {

class RoundsProgress;

/// Rays of one kind.
struct RaySet {
    RayKind kind = RayKind::diffuse;
    std::vector<Ray> rays;
};

/// Cost of a set of rays with one tree. Means over all rays; 0 where there are none.
struct RayCost {
    std::uint64_t ray_count = 0;
    std::uint64_t hits = 0;
    Sample trace_ms;  ///< Of the whole set, by the wall clock.
    double inner_per_ray = 0.0;
    double leaves_per_ray = 0.0;
    double triangles_per_ray = 0.0;
    double leaf_count_variability = 0.0;
    std::uint64_t mismatches = 0;  ///< Rays whose answer is not that of the reference.

    [[nodiscard]] double ns_per_ray() const;
    [[nodiscard]] double mrays_per_s() const;
    [[nodiscard]] double steps_per_ray() const { return inner_per_ray + leaves_per_ray; }
};

/// An engine that takes part, by the name that progress shows.
struct RayEntrant {
    std::string name;
    RayEngine* engine = nullptr;
};

/// Traces the set with every engine: once to count and to compare the answers with those of `reference`, then in `runs`
/// rounds (run_rounds), without counting, for the time. One result for each entrant.
[[nodiscard]] std::vector<RayCost> measure_rays(std::span<const RayEntrant> entrants, RayEngine& reference,
                                                const RaySet& set, std::size_t runs, RoundsProgress& progress);

}  // namespace clbvh::tool
