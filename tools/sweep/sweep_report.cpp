#include "sweep/sweep_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "report/column_table.hpp"

namespace clbvh::tool {
namespace {

double ns_per_triangle(const BuildResult& result) {
    return result.build_ms.median * 1e6 / static_cast<double>(result.triangles);
}

/// One value of one builder, beside the best that the builder reached at any value.
struct Row {
    const BuildResult* result;
    double least_ns;
    double least_sah;
};

std::vector<Row> make_rows(std::span<const BuildResult> results) {
    std::vector<Row> rows;
    for (const BuildResult& result : results) {
        Row row{&result, ns_per_triangle(result), result.sah};
        for (const BuildResult& other : results) {
            if (other.builder != result.builder) continue;
            row.least_ns = std::min(row.least_ns, ns_per_triangle(other));
            row.least_sah = std::min(row.least_sah, other.sah);
        }
        rows.push_back(row);
    }
    return rows;
}

std::vector<Column<Row>> columns_of(const std::string& what) {
    std::vector<Column<Row>> columns{
        {"builder", [](const Row& row) { return row.result->builder; }},
        {what, [](const Row& row) { return std::to_string(row.result->sweep->value); }},
        {"median ms", [](const Row& row) { return fixed_text(row.result->build_ms.median, 3); }},
        {"min ms", [](const Row& row) { return fixed_text(row.result->build_ms.min, 3); }},
        {"ns/triangle", [](const Row& row) { return fixed_text(ns_per_triangle(*row.result), 2); }},
        {"vs best", [](const Row& row) { return fixed_text(ns_per_triangle(*row.result) / row.least_ns, 2); }},
        {"x sort",
         [](const Row& row) {
             return fixed_text(row.result->build_ms.median / row.result->native_sort_ms->median, 2);
         }},
        {"SAH", [](const Row& row) { return fixed_text(row.result->sah, 3); }},
    };
    // Other sizes are other scenes: their costs say nothing of each other.
    if (what != "size")
        columns.push_back({"SAH/best", [](const Row& row) { return fixed_text(row.result->sah / row.least_sah, 4); }});
    columns.push_back({"valid", [](const Row& row) {
                           if (!row.result->valid) return "-";
                           return *row.result->valid ? "yes" : "NO";
                       }});
    return columns;
}

}  // namespace

std::string sweep_report(const std::string& scene, std::span<const BuildResult> results) {
    const std::string& what = results.front().sweep->what;
    const std::string triangles = what == "size" ? "" : fmt::format(" ({} triangles)", results.front().triangles);
    const std::vector<Row> rows = make_rows(results);
    return fmt::format("{}{}: {}\n{}", scene, triangles, what, table_text(columns_of(what), std::span(rows)));
}

}  // namespace clbvh::tool
