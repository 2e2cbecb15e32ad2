#include "report/stage_report.hpp"

#include <fmt/format.h>

#include <limits>
#include <vector>

#include "report/column_table.hpp"

namespace clbvh::tool {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

struct Row {
    std::string builder;
    std::string stage;
    double milliseconds;
    double share;
    double megabytes;
    double gb_per_s;
    double of_copy;
};

Row stage_row(const BuildResult& result, const StageStats& stage) {
    const bool on_host = ran_on_host(stage);
    const double milliseconds = on_host ? stage.host_ms : stage.device_ms;
    const double speed = gb_per_s(stage);
    return {result.builder,
            on_host ? stage.name + " (host)" : stage.name,
            milliseconds,
            milliseconds / result.build_ms.median,
            stage.bytes_moved > 0 ? static_cast<double>(stage.bytes_moved) * 1e-6 : kNone,
            speed,
            result.copy_gb_per_s ? speed / result.copy_gb_per_s->median : kNone};
}

Row overhead_row(const BuildResult& result) {
    const double milliseconds = result.launch_overhead_ms.median;
    return {result.builder, fmt::format("{} launch{}", result.launches, result.launches == 1 ? "" : "es"),
            milliseconds,   milliseconds / result.build_ms.median,
            kNone,          kNone,
            kNone};
}

std::string copy_line(const Sample& gb_per_s) {
    return fmt::format("copy on the device  {:.1f} GB/s read and written; launches: the build less all other rows\n",
                       gb_per_s.median);
}

const std::vector<Column<Row>>& columns() {
    static const std::vector<Column<Row>> list{
        {"builder", [](const Row& row) { return row.builder; }},
        {"stage", [](const Row& row) { return row.stage; }},
        {"ms", [](const Row& row) { return fixed_text(row.milliseconds, 3); }},
        {"share %", [](const Row& row) { return fixed_text(100.0 * row.share, 1); }},
        {"MB moved", [](const Row& row) { return fixed_text(row.megabytes, 1); }},
        {"GB/s", [](const Row& row) { return fixed_text(row.gb_per_s, 1); }},
        {"% of copy", [](const Row& row) { return fixed_text(100.0 * row.of_copy, 0); }},
    };
    return list;
}

}  // namespace

std::string stage_report(std::span<const BuildResult> results) {
    std::vector<Row> rows;
    std::string copy;
    for (const BuildResult& result : results) {
        if (result.kind != BuilderKind::device) continue;
        for (const StageStats& stage : result.stages)
            rows.push_back(stage_row(result, stage));
        rows.push_back(overhead_row(result));
        if (result.copy_gb_per_s) copy = copy_line(*result.copy_gb_per_s);
    }
    if (rows.empty()) return "no stages: none of these builders ran on a device\n";
    return table_text(columns(), std::span<const Row>(rows)) + copy;
}

}  // namespace clbvh::tool
