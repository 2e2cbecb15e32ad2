#include "bench_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "native_sort.hpp"
#include "table.hpp"

namespace clbvh::tool {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

std::string fixed(double value, int decimals) {
    return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "-";
}

std::string times(double value) {
    return std::isfinite(value) ? fmt::format("{:.2f}x", value) : "-";
}

std::string yes_no(const std::optional<bool>& valid) {
    if (!valid) return "-";
    return *valid ? "yes" : "NO";
}

/// The result of `ploc` on the same scene; null where it did not run.
const BuildResult* baseline(std::span<const BuildResult> scene) {
    const auto found =
        std::find_if(scene.begin(), scene.end(), [](const BuildResult& r) { return r.builder == "ploc"; });
    return found == scene.end() ? nullptr : &*found;
}

double speedup(const BuildResult& result, std::span<const BuildResult> scene) {
    const BuildResult* ploc = baseline(scene);
    return ploc != nullptr ? ploc->build_ms.median / result.build_ms.median : kUnknown;
}

double sah_over_baseline(const BuildResult& result, std::span<const BuildResult> scene) {
    const BuildResult* ploc = baseline(scene);
    return ploc != nullptr ? result.sah / ploc->sah : kUnknown;
}

double time_over_sort(const BuildResult& result) {
    return result.native_sort_ms ? result.build_ms.median / result.native_sort_ms->median : kUnknown;
}

std::string native_sort_line(const BuildResult& result) {
    const double ms = result.native_sort_ms.value_or(Sample{}).median;
    return fmt::format("native sort (64-bit keys, 32-bit values, {} threads)  {:.2f} ms  {} Mkeys/s\n",
                       NativeSort::threads(), ms, fixed(static_cast<double>(result.triangles) / ms / 1e3, 1));
}

}  // namespace

std::string scene_report(const DeviceInfo& device, std::span<const BuildResult> results) {
    const BuildResult& first = results.front();
    Table table({"builder", "median ms", "min ms", "Mtris/s", "vs ploc", "x sort", "SAH", "depth", "launches",
                 "iterations", "bytes/prim", "valid"});
    for (const BuildResult& result : results) {
        table.add_row({result.builder, fixed(result.build_ms.median, 2), fixed(result.build_ms.min, 2),
                       fixed(result.mtris_per_s(), 2), times(speedup(result, results)),
                       fixed(time_over_sort(result), 2), fixed(result.sah, 3), std::to_string(result.depth),
                       std::to_string(result.launches), std::to_string(result.iterations),
                       fixed(result.peak_bytes_per_primitive(), 1), yes_no(result.valid)});
    }
    return fmt::format("{}: {} triangles, {} shape, on {}\n{}{}", first.scene, first.triangles, to_string(first.shape),
                       device.name, table.text(), native_sort_line(first));
}

std::string means_report(std::span<const BuildResult> results, std::size_t builder_count) {
    Table table({"builder", "Mtris/s", "vs ploc", "x sort", "SAH/ploc"});
    for (std::size_t b = 0; b < builder_count; ++b) {
        std::vector<double> rates, speedups, sort_ratios, sah_ratios;
        for (std::size_t begin = 0; begin < results.size(); begin += builder_count) {
            const auto scene = results.subspan(begin, builder_count);
            rates.push_back(scene[b].mtris_per_s());
            speedups.push_back(speedup(scene[b], scene));
            sort_ratios.push_back(time_over_sort(scene[b]));
            sah_ratios.push_back(sah_over_baseline(scene[b], scene));
        }
        table.add_row({results[b].builder, fixed(geometric_mean(rates), 2), times(geometric_mean(speedups)),
                       fixed(geometric_mean(sort_ratios), 2), fixed(geometric_mean(sah_ratios), 4)});
    }
    return table.text();
}

}  // namespace clbvh::tool
