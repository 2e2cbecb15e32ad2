#include "aila2013/aila_report.hpp"

#include <fmt/format.h>

#include <array>
#include <clbvh/metrics/sah.hpp>
#include <functional>
#include <nlohmann/json.hpp>

#include "report/table.hpp"
#include "report/trace_result.hpp"

namespace clbvh::tool {
namespace {

using nlohmann::ordered_json;

/// One way to measure what rays cost; some have rows only where the device traced.
struct Measure {
    const char* name;  // in JSON
    const char* title;
    bool on_device;
    double (*value)(const MetricsResult&);
};

double whole(const MetricsResult& result) {
    return result.trace.cost.ns_per_ray();
}
double binary(const MetricsResult& result) {
    return result.binary_ns_per_ray();
}

/// Nodes and triangles that a ray visits, at the costs of SAH and EPO.
double visits(const MetricsResult& result) {
    constexpr SahCosts kCosts;
    const RayCost& cost = result.trace.cost;
    return kCosts.inner * cost.inner_per_ray + kCosts.primitive * cost.triangles_per_ray;
}

constexpr std::array kMeasures{
    Measure{"ns_per_ray", "ns/ray, host", false, whole},
    Measure{"binary_ns_per_ray", "host, binary", false, binary},
    Measure{"device_ns_per_ray", "ns/ray, device", true, whole},
    Measure{"device_binary_ns_per_ray", "device, binary", true, binary},
    Measure{"cost_per_ray", "cost/ray", false, visits},
};

const std::vector<MetricsResult>& results_of(const AilaScene& scene, const Measure& measure) {
    return measure.on_device ? scene.device : scene.host;
}

/// Correlations in the paper's last three columns, with their weights.
std::vector<std::string> fit_cells(const std::array<CostFit, 3>& fits) {
    const auto& [sah, with_epo, with_lcv] = fits;
    return {fixed_text(sah.correlation, 3),
            fmt::format("{} a={}", fixed_text(with_epo.correlation, 3), fixed_text(with_epo.weights.alpha, 2)),
            fmt::format("{} a={} b={}", fixed_text(with_lcv.correlation, 3), fixed_text(with_lcv.weights.alpha, 2),
                        fixed_text(with_lcv.weights.beta, 2))};
}

/// Rows whose columns are the builders, with room for correlations where there are any.
class Layout {
public:
    Layout(const AilaScene& scene, bool has_fits) : has_fits_(has_fits), table_(header(scene, has_fits)) {}

    void add(const char* title, std::span<const MetricsResult> results,
             const std::function<std::string(const MetricsResult&)>& cell, std::vector<std::string> fits = {}) {
        std::vector<std::string> cells{title};
        for (const MetricsResult& result : results)
            cells.push_back(cell(result));
        add(std::move(cells), std::move(fits));
    }
    void add(std::vector<std::string> cells, std::vector<std::string> fits = {}) {
        if (has_fits_) {
            fits.resize(3);
            cells.insert(cells.end(), fits.begin(), fits.end());
        }
        table_.add_row(std::move(cells));
    }
    [[nodiscard]] std::string text() const { return table_.text(); }

private:
    static std::vector<std::string> header(const AilaScene& scene, bool has_fits) {
        std::vector<std::string> cells{""};
        for (const AilaBuilder& builder : scene.builders)
            cells.emplace_back(builder.title);
        if (has_fits) cells.insert(cells.end(), {"with SAH", "SAH+EPO", "SAH+EPO+LCV"});
        return cells;
    }

    bool has_fits_;
    Table table_;
};

void add_measures(Layout& layout, const AilaScene& scene, std::span<const Prediction> predictions) {
    for (const Measure& measure : kMeasures) {
        const std::vector<MetricsResult>& results = results_of(scene, measure);
        if (results.empty()) continue;
        std::vector<std::string> fits;
        for (const Prediction& prediction : predictions) {
            if (prediction.measurement == measure.name) fits = fit_cells(prediction.fits);
        }
        layout.add(
            measure.title, results, [&](const MetricsResult& r) { return fixed_text(measure.value(r), 1); }, fits);
    }
}

std::string title_of(const AilaScene& scene) {
    std::string title = trace_title(scene.host.front().trace);
    if (!scene.device.empty()) title += fmt::format(", and on {}", scene.device.front().trace.traced_on);
    return title;
}

}  // namespace

std::vector<Prediction> predict(const AilaScene& scene) {
    std::vector<Prediction> predictions;
    if (scene.host.size() < kFewestPredicted) return predictions;
    for (const Measure& measure : kMeasures) {
        std::vector<TreeCost> trees;
        for (const MetricsResult& result : results_of(scene, measure))
            trees.push_back(result.cost(measure.value(result)));
        if (!trees.empty()) predictions.push_back(predict(scene.name, measure.name, std::move(trees)));
    }
    return predictions;
}

std::string aila_report(const AilaScene& scene, std::span<const Prediction> predictions) {
    using Result = const MetricsResult&;
    Layout layout(scene, !predictions.empty());
    add_measures(layout, scene, predictions);
    layout.add("SAH", scene.host, [](Result r) { return fixed_text(r.trace.sah, 2); });
    layout.add("EPO", scene.host, [](Result r) { return fixed_text(r.epo, 2); });
    layout.add("LCV", scene.host, [](Result r) { return fixed_text(r.trace.cost.leaf_count_variability, 2); });
    std::vector<std::string> times{"build ms"};
    for (const double milliseconds : scene.build_ms)
        times.push_back(fixed_text(milliseconds, milliseconds < 100.0 ? 1 : 0));
    layout.add(std::move(times));
    return fmt::format("{}\n{}", title_of(scene), layout.text());
}

ordered_json to_json(const AilaScene& scene) {
    ordered_json list = ordered_json::array();
    for (std::size_t i = 0; i < scene.builders.size(); ++i) {
        const AilaBuilder& builder = scene.builders[i];
        ordered_json& json = list.emplace_back(to_json(scene.host[i]));
        json["title"] = builder.title;
        json["made_by"] = builder.builder;
        json["optimizers"] = builder.optimizers;
        json["build_ms"] = scene.build_ms[i];
        json["cost_per_ray"] = visits(scene.host[i]);
        if (scene.device.empty()) continue;
        const MetricsResult& on_device = scene.device[i];
        json["device_ns_per_ray"] = on_device.trace.cost.ns_per_ray();
        json["device_binary_ns_per_ray"] = on_device.binary_ns_per_ray();
        json["device_mismatches"] = on_device.trace.cost.mismatches;
    }
    return list;
}

}  // namespace clbvh::tool
