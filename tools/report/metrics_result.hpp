#pragma once

#include <clbvh/eval/cost_fit.hpp>
#include <clbvh/metrics/tree_statistics.hpp>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>

#include "measure/sample.hpp"
#include "report/trace_result.hpp"

namespace clbvh::tool {

/// Metrics of one builder's tree, and the cost of its rays.
struct MetricsResult {
    TraceResult trace;
    TreeStatistics statistics;
    double ray_cost = 0.0;  ///< SurfaceRayCost::cost
    double epo = 0.0;
    std::optional<double> epo_error;  ///< Standard error; absent where EPO is exact.
    double epo_ms = 0.0;              ///< Wall time to compute it.
    Sample binary_trace_ms;           ///< Of the same rays through the tree's own nodes, counting what they visit.

    [[nodiscard]] double binary_ns_per_ray() const;
    /// With the measurement `ns_per_ray`.
    [[nodiscard]] TreeCost cost(double ns_per_ray) const;
};

/// The fields of `trace`, and those of the tree.
[[nodiscard]] nlohmann::ordered_json to_json(const MetricsResult& result);

/// The table of one scene.
[[nodiscard]] std::string metrics_report(std::span<const MetricsResult> results);

}  // namespace clbvh::tool
