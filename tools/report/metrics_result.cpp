#include "report/metrics_result.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "report/column_table.hpp"

namespace clbvh::tool {
namespace {

double primitives_per_leaf(const TreeStatistics& statistics) {
    return statistics.leaves > 0 ? static_cast<double>(statistics.references) / static_cast<double>(statistics.leaves)
                                 : 0.0;
}

std::string epo_text(const MetricsResult& result) {
    const std::string value = fixed_text(result.epo, 3);
    return result.epo_error ? fmt::format("{} +- {}", value, fixed_text(*result.epo_error, 3)) : value;
}

}  // namespace

double MetricsResult::binary_ns_per_ray() const {
    return binary_trace_ms.median * 1e6 / static_cast<double>(trace.cost.ray_count);
}

TreeCost MetricsResult::cost(double ns_per_ray) const {
    return {trace.sah, epo, trace.cost.leaf_count_variability, ns_per_ray};
}

nlohmann::ordered_json to_json(const MetricsResult& result) {
    nlohmann::ordered_json json = to_json(result.trace);
    json.erase("relative_speed");  // there need not be a baseline
    json["binary_ns_per_ray"] = result.binary_ns_per_ray();
    json["ray_cost"] = result.ray_cost;
    json["epo"] = result.epo;
    if (result.epo_error) json["epo_standard_error"] = *result.epo_error;
    json["epo_ms"] = result.epo_ms;
    json["lcv"] = result.trace.cost.leaf_count_variability;
    json["steps_per_ray"] = result.trace.cost.steps_per_ray();
    json["sibling_overlap"] = result.statistics.sibling_overlap;
    json["depth"] = result.statistics.depth();
    json["mean_leaf_depth"] = result.statistics.mean_leaf_depth();
    json["nodes"] = result.statistics.nodes;
    json["leaves"] = result.statistics.leaves;
    json["references"] = result.statistics.references;
    json["leaves_by_depth"] = result.statistics.leaves_by_depth;
    json["leaves_by_size"] = result.statistics.leaves_by_size;
    return json;
}

std::string metrics_report(std::span<const MetricsResult> results) {
    using Result = const MetricsResult&;
    const std::vector<Column<MetricsResult>> columns{
        {"builder", [](Result r) { return r.trace.builder; }},
        {"SAH", [](Result r) { return fixed_text(r.trace.sah, 3); }},
        {"ray cost", [](Result r) { return fixed_text(r.ray_cost, 2); }},
        {"EPO", epo_text},
        {"LCV", [](Result r) { return fixed_text(r.trace.cost.leaf_count_variability, 3); }},
        {"overlap", [](Result r) { return fixed_text(r.statistics.sibling_overlap, 3); }},
        {"depth", [](Result r) { return std::to_string(r.statistics.depth()); }},
        {"mean depth", [](Result r) { return fixed_text(r.statistics.mean_leaf_depth(), 1); }},
        {"leaves", [](Result r) { return std::to_string(r.statistics.leaves); }},
        {"prims/leaf", [](Result r) { return fixed_text(primitives_per_leaf(r.statistics), 2); }},
        {"steps/ray", [](Result r) { return fixed_text(r.trace.cost.steps_per_ray(), 2); }},
        {"tris/ray", [](Result r) { return fixed_text(r.trace.cost.triangles_per_ray, 2); }},
        {"ns/ray", [](Result r) { return fixed_text(r.trace.cost.ns_per_ray(), 1); }},
        {"binary", [](Result r) { return fixed_text(r.binary_ns_per_ray(), 1); }},
    };
    return fmt::format("{}\n{}", trace_title(results.front().trace), table_text(columns, results));
}

}  // namespace clbvh::tool
