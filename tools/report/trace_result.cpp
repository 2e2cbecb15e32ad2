#include "report/trace_result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>

#include "cli/complain.hpp"
#include "cli/exit_code.hpp"
#include "measure/build_result.hpp"
#include "report/column_table.hpp"
#include "report/result_json.hpp"

namespace clbvh::tool {
namespace {

/// The results of the first set in `results`.
std::span<const TraceResult> first_set(std::span<const TraceResult> results) {
    const auto end = std::ranges::find_if(results, [&](const TraceResult& r) { return r.rays != results[0].rays; });
    return results.first(static_cast<std::size_t>(end - results.begin()));
}

std::string set_report(std::span<const TraceResult> results) {
    using Result = const TraceResult&;
    const std::vector<Column<TraceResult>> columns{
        {"builder", [](Result r) { return r.builder; }},
        {"Mrays/s", [](Result r) { return fixed_text(r.cost.mrays_per_s(), 3); }},
        {"ns/ray", [](Result r) { return fixed_text(r.cost.ns_per_ray(), 1); }},
        {fmt::format("vs {}", kTraceBaseline), [](Result r) { return fixed_text(r.speed, 3) + "x"; }},
        {"inner/ray", [](Result r) { return fixed_text(r.cost.inner_per_ray, 2); }},
        {"leaves/ray", [](Result r) { return fixed_text(r.cost.leaves_per_ray, 2); }},
        {"tris/ray", [](Result r) { return fixed_text(r.cost.triangles_per_ray, 2); }},
        {"SAH", [](Result r) { return fixed_text(r.sah, 3); }},
        {"hits", [](Result r) { return std::to_string(r.cost.hits); }},
    };
    return fmt::format("{}\n{}", trace_title(results.front()), table_text(columns, results));
}

}  // namespace

std::string trace_title(const TraceResult& result) {
    std::string title = fmt::format("{}: {} triangles; {} {} rays on {}", result.scene, result.triangles,
                                    result.cost.ray_count, to_string(result.rays), result.traced_on);
    if (result.threads > 0) title += fmt::format(", {}", threads_text(result.threads));
    return title;
}

nlohmann::ordered_json to_json(const TraceResult& result) {
    nlohmann::ordered_json json{
        {"scene", result.scene},
        {"triangles", result.triangles},
        {"builder", result.builder},
        {"kind", to_string(result.kind)},
        {"sah", result.sah},
        {"device", result.traced_on},
        {"rays", to_string(result.rays)},
        {"ray_count", result.cost.ray_count},
        {"ray_hash", fmt::format("{:016x}", result.hash)},
    };
    if (result.threads > 0) json["threads"] = result.threads;
    if (result.loaded_from.empty()) {
        json["seed"] = result.seed;
        json["camera"] = result.camera;
    } else {
        json["loaded_from"] = result.loaded_from;
    }
    json["hits"] = result.cost.hits;
    json["mismatches"] = result.cost.mismatches;
    json["trace_ms"] = sample_json(result.cost.trace_ms);
    json["mrays_per_s"] = result.cost.mrays_per_s();
    json["ns_per_ray"] = result.cost.ns_per_ray();
    json["relative_speed"] = result.speed;
    json["inner_per_ray"] = result.cost.inner_per_ray;
    json["leaves_per_ray"] = result.cost.leaves_per_ray;
    json["triangles_per_ray"] = result.cost.triangles_per_ray;
    return json;
}

std::string trace_report(std::span<const TraceResult> results) {
    std::string text;
    while (!results.empty()) {
        const std::span<const TraceResult> set = first_set(results);
        if (!text.empty()) text += '\n';
        text += set_report(set);
        results = results.subspan(set.size());
    }
    return text;
}

int report_mismatches(std::span<const TraceResult> results) {
    int code = kExitSuccess;
    for (const TraceResult& result : results) {
        if (result.cost.mismatches == 0) continue;
        complain(fmt::format("{} of {} {} rays hit something else with the tree of {} over {}, traced on {}",
                             result.cost.mismatches, result.cost.ray_count, to_string(result.rays), result.builder,
                             result.scene, result.traced_on));
        code = kExitInvalidTree;
    }
    return code;
}

}  // namespace clbvh::tool
