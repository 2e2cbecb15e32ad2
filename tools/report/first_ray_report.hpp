#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "measure/first_ray.hpp"

namespace clbvh::tool {

/// The table of one scene; behind a ray's time as one of many, in brackets, what it takes alone. At least one result.
[[nodiscard]] std::string first_ray_report(std::span<const FirstRayResult> results);

/// Geometric means over several scenes. `results` holds scene after scene, and for each of them the same
/// `entrant_count` entrants in the same order.
[[nodiscard]] std::string first_ray_means(std::span<const FirstRayResult> results, std::size_t entrant_count);

/// One object a result: scene, triangles, builder, peer, first_ray_ms {median, min, max}, cold_ms, stages [{name,
/// host_ms}], primary_ns, closest_ns, any_ns (rays in spans; a peer's one by one), the same with _single_ns (one by
/// one; null for a peer) and bytes_per_triangle, null where not measured or not known.
[[nodiscard]] nlohmann::ordered_json to_json(std::span<const FirstRayResult> results);

}  // namespace clbvh::tool
