#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace clbvh {

/// Cost of one stage of a build.
///
/// Device builders have the stages "bounds", "morton", "sort", "cluster" and "root", BatchBuilder has "batch" alone.
/// Host builders begin with "bounds" and end with "layout", and have of "morton", "sort", "order", "build" and
/// "cluster" those that they need between. A build that splits triangles begins with "presplit". One with optimisers
/// has a stage named after the id of each; one whose leaves the host merges, or whose triangles were split, ends with
/// "collapse"; whatever the host works on has "download" first where a device built the tree. BuildOptions::ray_cost
/// adds "ray-cost", and Builder::build_layout has "wide8" last.
struct StageStats {
    std::string name;        ///< One of those above.
    double device_ms = 0.0;  ///< Sum of the kernels' execution times on the device; 0 where the queue does not profile.
    double host_ms = 0.0;    ///< Wall time that the host spent in the stage's calls, its waits for the device included.
    std::uint32_t launches = 0;     ///< Kernels enqueued.
    std::uint64_t bytes_moved = 0;  ///< Global memory that the kernels must read and write, counted from sizes: every
                                    ///< array once a pass, whatever caches save or gathers waste. 0: not counted.
};

/// Cost and results of a build.
struct BuildStats {
    std::vector<StageStats> stages;
    double build_ms = 0.0;         ///< Wall time from device-resident input to device-resident finished tree.
    std::uint32_t launches = 0;    ///< Kernels enqueued, all stages.
    std::uint32_t iterations = 0;  ///< Rounds of clustering that the host launched one by one; 0 for other builders.
    std::vector<std::uint32_t> clusters_per_iteration;  ///< Clusters alive at the start of each of those iterations.
    std::uint64_t peak_device_bytes = 0;                ///< Largest sum of the build's device buffers, input excluded.
    std::uint64_t peak_host_bytes = 0;  ///< Most that the host's work took: scratch, trees and parts of triangles;
                                        ///< input and download() excluded.
    double ray_cost = 0.0;  ///< With BuildOptions::ray_cost, SurfaceRayCost::cost of the finished tree; else 0.
    std::uint64_t inactive_primitives = 0;  ///< Primitives with a NaN coordinate, left out of the tree.
};

/// How far a build is.
struct Progress {
    std::string_view stage;  ///< Name of the stage at work.
    double fraction = 0.0;   ///< Estimated part of the whole build that is done, 0 to 1, never falling.
};

/// Called on the building thread, between launches, and on the host while a stage is at work. Returning false cancels:
/// the build throws Error(cancelled), and the builder can be used again.
using ProgressCallback = std::function<bool(const Progress&)>;

}  // namespace clbvh
