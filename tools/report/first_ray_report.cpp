#include "report/first_ray_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "report/column_table.hpp"
#include "report/result_json.hpp"

namespace clbvh::tool {
namespace {

using nlohmann::ordered_json;

double or_nan(const std::optional<double>& value) {
    return value.value_or(std::numeric_limits<double>::quiet_NaN());
}

ordered_json or_null(const std::optional<double>& value) {
    return value ? ordered_json(*value) : ordered_json(nullptr);
}

double ms_per_million(const FirstRayResult& result) {
    return result.triangles > 0 ? result.first_ray_ms.median * 1e6 / static_cast<double>(result.triangles)
                                : std::numeric_limits<double>::quiet_NaN();
}

/// Of a ray among many, and of a ray alone.
std::string ray_text(const std::optional<double>& span, const std::optional<double>& single) {
    return single ? fmt::format("{} ({})", fixed_text(or_nan(span), 1), fixed_text(*single, 1))
                  : fixed_text(or_nan(span), 1);
}

/// The columns that scenes and means have.
std::vector<Column<FirstRayResult>> first_ray_columns() {
    return {
        {"builder", [](const FirstRayResult& r) { return r.builder; }},
        {"first ray ms", [](const FirstRayResult& r) { return fixed_text(r.first_ray_ms.median, 2); }},
        {"ms/Mtri", [](const FirstRayResult& r) { return fixed_text(ms_per_million(r), 1); }},
        {"cold ms", [](const FirstRayResult& r) { return fixed_text(r.cold_ms, 1); }},
        {"primary ns", [](const FirstRayResult& r) { return ray_text(r.primary_ns, r.primary_single_ns); }},
        {"diffuse ns", [](const FirstRayResult& r) { return ray_text(r.closest_ns, r.closest_single_ns); }},
        {"any hit ns", [](const FirstRayResult& r) { return ray_text(r.any_ns, r.any_single_ns); }},
        {"bytes/tri", [](const FirstRayResult& r) { return fixed_text(or_nan(r.bytes_per_triangle), 0); }},
    };
}

/// The geometric mean of one number of an entrant over all scenes.
template <typename Value>
double mean_of(std::span<const FirstRayResult> results, std::size_t entrant, std::size_t count, const Value& value) {
    std::vector<double> values;
    for (std::size_t i = entrant; i < results.size(); i += count)
        values.push_back(value(results[i]));
    return geometric_mean(values);
}

}  // namespace

std::string first_ray_report(std::span<const FirstRayResult> results) {
    return fmt::format("{}: {} triangles\n{}", results.front().scene, results.front().triangles,
                       table_text(first_ray_columns(), results));
}

std::string first_ray_means(std::span<const FirstRayResult> results, std::size_t entrant_count) {
    std::vector<FirstRayResult> means;
    for (std::size_t entrant = 0; entrant < entrant_count; ++entrant) {
        const auto mean = [&](const auto& value) { return mean_of(results, entrant, entrant_count, value); };
        FirstRayResult& row = means.emplace_back(results[entrant]);
        row.triangles = 1'000'000;  // times are those of a million
        row.first_ray_ms.median = mean(ms_per_million);
        row.cold_ms = mean([](const FirstRayResult& r) { return r.cold_ms; });
        for (const auto nanoseconds :
             {&FirstRayResult::primary_ns, &FirstRayResult::primary_single_ns, &FirstRayResult::closest_ns,
              &FirstRayResult::closest_single_ns, &FirstRayResult::any_ns, &FirstRayResult::any_single_ns}) {
            if (row.*nanoseconds)
                row.*nanoseconds = mean([&](const FirstRayResult& r) { return or_nan(r.*nanoseconds); });
        }
        row.bytes_per_triangle = mean([](const FirstRayResult& r) { return or_nan(r.bytes_per_triangle); });
    }
    return table_text(first_ray_columns(), std::span<const FirstRayResult>(means));
}

ordered_json to_json(std::span<const FirstRayResult> results) {
    ordered_json list = ordered_json::array();
    for (const FirstRayResult& result : results) {
        ordered_json stages = ordered_json::array();
        for (const StageStats& stage : result.stages)
            stages.push_back({{"name", stage.name}, {"host_ms", stage.host_ms}});
        list.push_back({{"scene", result.scene},
                        {"triangles", result.triangles},
                        {"builder", result.builder},
                        {"peer", result.is_peer},
                        {"first_ray_ms", sample_json(result.first_ray_ms)},
                        {"cold_ms", result.cold_ms},
                        {"stages", std::move(stages)},
                        {"primary_ns", or_null(result.primary_ns)},
                        {"primary_single_ns", or_null(result.primary_single_ns)},
                        {"closest_ns", or_null(result.closest_ns)},
                        {"closest_single_ns", or_null(result.closest_single_ns)},
                        {"any_ns", or_null(result.any_ns)},
                        {"any_single_ns", or_null(result.any_single_ns)},
                        {"bytes_per_triangle", or_null(result.bytes_per_triangle)}});
    }
    return list;
}

}  // namespace clbvh::tool
