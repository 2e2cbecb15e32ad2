#pragma once

#include <clbvh/catalog.hpp>
#include <clbvh/eval/camera.hpp>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "measure/ray_cost.hpp"

namespace clbvh::tool {

/// The cost of one set of rays in the tree of one builder, and the qualities of that tree.
struct TraceResult {
    std::string scene;
    std::uint64_t triangles = 0;
    std::string builder;
    BuilderKind kind = BuilderKind::host;
    double sah = 0.0;
    std::string traced_on;      ///< "host", or the device's name.
    std::uint32_t threads = 0;  ///< Of the host's tracing; 0 on a device.
    RayKind rays = RayKind::diffuse;
    std::uint64_t seed = 0;
    std::uint64_t hash = 0;   ///< hash_rays() of the set.
    std::string camera;       ///< As parse_camera reads it, in the scene as it was traced.
    std::string loaded_from;  ///< The file that the rays came from; else empty, and seed and camera say how they did.
    RayCost cost;
    double speed = 0.0;  ///< Relative to the baseline's: above 1 is faster.
};

/// The builder that others are compared with.
inline constexpr const char* kTraceBaseline = "binned-sah";

[[nodiscard]] nlohmann::ordered_json to_json(const TraceResult& result);

/// "SCENE: N triangles; N diffuse rays on host, 2 threads", for above a table.
[[nodiscard]] std::string trace_title(const TraceResult& result);

/// The tables of one scene, one for each set of rays. `results` holds set after set.
[[nodiscard]] std::string trace_report(std::span<const TraceResult> results);

/// Tells standard error about each builder whose hits are not the first one's, and returns the exit code.
[[nodiscard]] int report_mismatches(std::span<const TraceResult> results);

}  // namespace clbvh::tool
