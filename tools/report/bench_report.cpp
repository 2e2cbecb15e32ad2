#include "report/bench_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <string_view>
#include <vector>

#include "measure/native_sort.hpp"
#include "report/column_table.hpp"

namespace clbvh::tool {
namespace {

// Baseline of the others, in time and in quality: the first of these that ran.
using Baselines = std::array<std::string_view, 2>;
constexpr Baselines kTimeBaselines{"ploc", "binned-sah"};
constexpr Baselines kSahBaselines{"binned-sah", "ploc"};

std::string times(double value) {
    return std::isfinite(value) ? fmt::format("{:.2f}x", value) : "-";
}

std::string yes_no(const std::optional<bool>& valid) {
    if (!valid) return "-";
    return *valid ? "yes" : "NO";
}

/// The results of one scene, and what they are compared with; null where it did not run.
class Comparison {
public:
    explicit Comparison(std::span<const BuildResult> scene)
        : time_baseline_(find(scene, kTimeBaselines)),
          sah_baseline_(find(scene, kSahBaselines)),
          traced_(std::ranges::any_of(scene, [](const BuildResult& result) { return result.rays.has_value(); })) {}

    [[nodiscard]] const BuildResult* time_baseline() const { return time_baseline_; }
    [[nodiscard]] const BuildResult* sah_baseline() const { return sah_baseline_; }
    /// Whether rays were traced through any of the trees.
    [[nodiscard]] bool traced() const { return traced_; }

    /// The rest where there is a baseline.
    [[nodiscard]] double speedup(const BuildResult& result) const {
        return time_baseline_->build_ms.median / result.build_ms.median;
    }
    /// NaN where the result has no tree to read.
    [[nodiscard]] double sah_ratio(const BuildResult& result) const {
        return result.has_tree ? result.sah / sah_baseline_->sah : std::numeric_limits<double>::quiet_NaN();
    }
    /// How many times what the SAH cost says, beside that of the same baseline, rays from surfaces cost.
    [[nodiscard]] double ray_cost_over_sah(const BuildResult& result) const {
        return result.ray_cost / sah_baseline_->ray_cost / sah_ratio(result);
    }
    [[nodiscard]] std::string speedup_title() const { return "vs " + time_baseline_->builder; }
    [[nodiscard]] std::string sah_ratio_title() const { return "SAH/" + sah_baseline_->builder; }

private:
    static const BuildResult* find(std::span<const BuildResult> scene, const Baselines& ids) {
        for (const std::string_view id : ids) {
            const auto found = std::ranges::find(scene, id, &BuildResult::builder);
            if (found != scene.end()) return &*found;
        }
        return nullptr;
    }

    const BuildResult* time_baseline_;
    const BuildResult* sah_baseline_;
    bool traced_;
};

double time_over_sort(const BuildResult& result) {
    return result.native_sort_ms ? result.build_ms.median / result.native_sort_ms->median
                                 : std::numeric_limits<double>::quiet_NaN();
}

/// A column about the tree: a dash where there is none to read.
std::function<std::string(const BuildResult&)> of_tree(std::string (*cell)(const BuildResult&)) {
    return [cell](const BuildResult& result) { return result.has_tree ? cell(result) : std::string("-"); };
}

/// A column about rays: a dash where none were traced.
std::function<std::string(const BuildResult&)> of_rays(std::string (*cell)(const RayCost&)) {
    return [cell](const BuildResult& result) { return result.rays ? cell(*result.rays) : std::string("-"); };
}

std::vector<Column<BuildResult>> scene_columns(const Comparison& comparison) {
    using Result = const BuildResult&;
    std::vector<Column<BuildResult>> columns{
        {"builder", [](Result r) { return r.builder; }},
        {"median ms", [](Result r) { return fixed_text(r.build_ms.median, 2); }},
        {"min ms", [](Result r) { return fixed_text(r.build_ms.min, 2); }},
        {"Mtris/s", [](Result r) { return fixed_text(r.mtris_per_s(), 2); }},
    };
    if (comparison.time_baseline() != nullptr)
        columns.push_back({comparison.speedup_title(), [&](Result r) { return times(comparison.speedup(r)); }});
    columns.push_back({"x sort", [](Result r) { return fixed_text(time_over_sort(r), 2); }});
    columns.push_back({"SAH", of_tree([](Result r) { return fixed_text(r.sah, 3); })});
    if (comparison.sah_baseline() != nullptr)
        columns.push_back(
            {comparison.sah_ratio_title(), [&](Result r) { return fixed_text(comparison.sah_ratio(r), 4); }});
    columns.push_back({"ray cost", of_tree([](Result r) { return fixed_text(r.ray_cost, 2); })});
    columns.push_back({"depth", of_tree([](Result r) { return std::to_string(r.depth); })});
    columns.push_back({"leaves", of_tree([](Result r) { return std::to_string(r.leaves); })});
    columns.push_back({"prims/leaf", of_tree([](Result r) { return fixed_text(r.primitives_per_leaf(), 2); })});
    if (comparison.traced()) {
        columns.push_back({"ns/ray", of_rays([](const RayCost& rays) { return fixed_text(rays.ns_per_ray(), 1); })});
        columns.push_back({"binary", [](Result r) { return r.rays ? fixed_text(r.binary_ns_per_ray, 1) : "-"; }});
        columns.push_back(
            {"steps/ray", of_rays([](const RayCost& rays) { return fixed_text(rays.steps_per_ray(), 1); })});
    }
    columns.push_back({"bytes/prim", [](Result r) { return fixed_text(r.peak_bytes_per_primitive(), 1); }});
    columns.push_back({"valid", [](Result r) { return yes_no(r.valid); }});
    return columns;
}

/// The rule for leaves that all builders share: SAH compares trees only where they are made by one rule. Other
/// libraries' builders, which have no options of ours, are given the same.
std::string leaf_rule(std::span<const BuildResult> results) {
    std::uint32_t common = 0;
    for (const BuildResult& result : results) {
        if (!result.options) continue;
        const std::uint32_t size = result.options->max_leaf_size;
        if (size == 0 || (common != 0 && size != common)) return "leaves as each builder makes them";
        common = size;
    }
    return fmt::format("leaves of up to {} primitives", common);
}

/// "SCENE: N triangles; leaves of up to N primitives; lane shape on DEVICE; host builders on N threads".
std::string scene_title(const std::optional<Context>& context, std::span<const BuildResult> results) {
    std::string title =
        fmt::format("{}: {} triangles; {}", results.front().scene, results.front().triangles, leaf_rule(results));
    const auto first = [&](BuilderKind kind) { return std::ranges::find(results, kind, &BuildResult::kind); };
    if (const auto result = first(BuilderKind::device); result != results.end() && context)
        title += fmt::format("; {} shape on {}", to_string(result->shape), context->device().name);
    if (const auto result = first(BuilderKind::host); result != results.end())
        title += fmt::format("; host builders on {}", threads_text(result->threads));
    return title;
}

/// A line for each tree of which the SAH cost says something else than what rays cost.
std::string disagreements(const Comparison& comparison, std::span<const BuildResult> results) {
    constexpr double most = 2.0;
    std::string text;
    if (comparison.sah_baseline() == nullptr) return text;
    for (const BuildResult& result : results) {
        const double times = comparison.ray_cost_over_sah(result);
        if (!(times > most || times < 1.0 / most)) continue;
        text += fmt::format(
            "note: rays from surfaces cost {} times in the tree of {} what they do in that of {}, where "
            "the SAH cost says {}\n",
            fixed_text(times * comparison.sah_ratio(result), 2), result.builder, comparison.sah_baseline()->builder,
            fixed_text(comparison.sah_ratio(result), 2));
    }
    return text;
}

std::string native_sort_line(const BuildResult& result) {
    const double ms = result.native_sort_ms.value_or(Sample{}).median;
    return fmt::format("native sort (64-bit keys, 32-bit values, {})  {:.2f} ms  {} Mkeys/s\n",
                       threads_text(NativeSort::threads()), ms,
                       fixed_text(static_cast<double>(result.triangles) / ms / 1e3, 1));
}

/// One builder in the table of means: its results, scene by scene, each with those that it is compared with.
struct Series {
    struct Entry {
        const BuildResult* result;
        Comparison comparison;
    };
    std::vector<Entry> entries;

    template <typename Value>
    [[nodiscard]] double mean(const Value& value) const {
        std::vector<double> values;
        for (const Entry& entry : entries)
            values.push_back(value(entry));
        return geometric_mean(values);
    }
};

std::vector<Column<Series>> means_columns(const Comparison& comparison) {
    using Entry = const Series::Entry&;
    std::vector<Column<Series>> columns{
        {"builder", [](const Series& s) { return s.entries.front().result->builder; }},
        {"Mtris/s",
         [](const Series& s) { return fixed_text(s.mean([](Entry e) { return e.result->mtris_per_s(); }), 2); }},
    };
    if (comparison.time_baseline() != nullptr) {
        columns.push_back({comparison.speedup_title(), [](const Series& s) {
                               return times(s.mean([](Entry e) { return e.comparison.speedup(*e.result); }));
                           }});
    }
    columns.push_back({"x sort", [](const Series& s) {
                           return fixed_text(s.mean([](Entry e) { return time_over_sort(*e.result); }), 2);
                       }});
    if (comparison.sah_baseline() != nullptr) {
        columns.push_back({comparison.sah_ratio_title(), [](const Series& s) {
                               return fixed_text(s.mean([](Entry e) { return e.comparison.sah_ratio(*e.result); }), 4);
                           }});
    }
    return columns;
}

}  // namespace

std::string scene_report(const std::optional<Context>& context, std::span<const BuildResult> results) {
    const Comparison comparison(results);
    return fmt::format("{}\n{}{}{}", scene_title(context, results), table_text(scene_columns(comparison), results),
                       disagreements(comparison, results), native_sort_line(results.front()));
}

std::string means_report(std::span<const BuildResult> results, std::size_t builder_count) {
    std::vector<Series> rows(builder_count);
    for (std::size_t begin = 0; begin < results.size(); begin += builder_count) {
        const auto scene = results.subspan(begin, builder_count);
        const Comparison comparison(scene);
        for (std::size_t b = 0; b < builder_count; ++b)
            rows[b].entries.push_back({&scene[b], comparison});
    }
    return table_text(means_columns(Comparison(results.first(builder_count))), std::span<const Series>(rows));
}

std::string unavailable_report(const BuilderChoice& choice) {
    if (choice.unavailable_ids.empty()) return {};
    return fmt::format("not available: {}\n  {}\n", fmt::join(choice.unavailable_ids, ", "), choice.reason);
}

}  // namespace clbvh::tool
