#include "report/cost_prediction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <clbvh/eval/cost_fit.hpp>
#include <nlohmann/json.hpp>
#include <utility>

#include "report/table.hpp"

namespace clbvh::tool {
namespace {

using nlohmann::ordered_json;

struct Terms {
    CostTerms terms;
    const char* title;
    const char* name;  // in JSON
};

constexpr std::array kAllTerms{Terms{CostTerms::sah, "SAH", "sah"}, Terms{CostTerms::sah_epo, "SAH+EPO", "sah_epo"},
                               Terms{CostTerms::sah_epo_lcv, "SAH+EPO+LCV", "sah_epo_lcv"}};

struct Measurement {
    const char* name;  // in JSON
    const char* title;
};

constexpr std::array kMeasurements{Measurement{"ns_per_ray", "ns/ray"}, Measurement{"binary_ns_per_ray", "binary"},
                                   Measurement{"device_ns_per_ray", "device"},
                                   Measurement{"device_binary_ns_per_ray", "device, binary"},
                                   Measurement{"cost_per_ray", "cost/ray"}};

std::string title_of(const std::string& measurement) {
    const auto known = std::ranges::find(kMeasurements, measurement, &Measurement::name);
    return known == kMeasurements.end() ? measurement : known->title;
}

/// One measurement over all scenes.
struct Pool {
    std::string measurement;
    std::size_t scene_count = 0;
    std::array<double, 3> means{};
    std::array<double, 3> minima{1.0, 1.0, 1.0};
    std::array<CostFit, 3> shared;  ///< The same weights for all scenes.
};

Pool make_pool(std::span<const Prediction> predictions, const char* measurement) {
    Pool pool;
    pool.measurement = measurement;
    std::vector<std::vector<TreeCost>> scenes;
    for (const Prediction& prediction : predictions) {
        if (prediction.measurement != measurement) continue;
        scenes.push_back(prediction.trees);
        for (std::size_t i = 0; i < kAllTerms.size(); ++i) {
            pool.means[i] += prediction.fits[i].correlation;
            pool.minima[i] = std::min(pool.minima[i], prediction.fits[i].correlation);
        }
    }
    pool.scene_count = scenes.size();
    for (double& mean : pool.means)
        mean /= static_cast<double>(std::max<std::size_t>(1, scenes.size()));
    std::ranges::transform(kAllTerms, pool.shared.begin(),
                           [&](const Terms& terms) { return fit_costs(scenes, terms.terms); });
    return pool;
}

/// Those over two scenes or more.
std::vector<Pool> make_pools(std::span<const Prediction> predictions) {
    std::vector<Pool> pools;
    for (const Measurement& measurement : kMeasurements) {
        Pool pool = make_pool(predictions, measurement.name);
        if (pool.scene_count >= 2) pools.push_back(std::move(pool));
    }
    return pools;
}

std::vector<std::string> header(const char* first) {
    return {first, "SAH", "SAH+EPO", "alpha", "SAH+EPO+LCV", "alpha", "beta"};
}

std::vector<std::string> row(const std::string& first, const std::array<CostFit, 3>& fits) {
    const auto& [sah, with_epo, with_lcv] = fits;
    return {first,
            fixed_text(sah.correlation, 3),
            fixed_text(with_epo.correlation, 3),
            fixed_text(with_epo.weights.alpha, 2),
            fixed_text(with_lcv.correlation, 3),
            fixed_text(with_lcv.weights.alpha, 2),
            fixed_text(with_lcv.weights.beta, 2)};
}

std::vector<std::string> row(const std::string& first, const std::array<double, 3>& correlations) {
    const auto& [sah, with_epo, with_lcv] = correlations;
    return {first, fixed_text(sah, 3), fixed_text(with_epo, 3), "", fixed_text(with_lcv, 3), "", ""};
}

ordered_json fit_json(const Terms& terms, const CostFit& fit) {
    ordered_json json{{"correlation", fit.correlation}};
    if (terms.terms != CostTerms::sah) json["alpha"] = fit.weights.alpha;
    if (terms.terms == CostTerms::sah_epo_lcv) json["beta"] = fit.weights.beta;
    return json;
}

ordered_json pool_json(const Pool& pool) {
    ordered_json json{{"measurement", pool.measurement}, {"scenes", pool.scene_count}};
    for (std::size_t i = 0; i < kAllTerms.size(); ++i) {
        json[kAllTerms[i].name] = {
            {"mean", pool.means[i]}, {"minimum", pool.minima[i]}, {"shared", fit_json(kAllTerms[i], pool.shared[i])}};
    }
    return json;
}

}  // namespace

Prediction predict(std::string scene, std::string measurement, std::vector<TreeCost> trees) {
    Prediction prediction{std::move(scene), std::move(measurement), std::move(trees), {}};
    std::ranges::transform(kAllTerms, prediction.fits.begin(),
                           [&](const Terms& terms) { return fit_costs(prediction.trees, terms.terms); });
    return prediction;
}

std::vector<Prediction> predict(std::span<const MetricsResult> of_scene) {
    if (of_scene.size() < kFewestPredicted) return {};
    const std::string& scene = of_scene.front().trace.scene;
    std::vector<TreeCost> trees;
    std::vector<TreeCost> binary_trees;
    for (const MetricsResult& result : of_scene) {
        trees.push_back(result.cost(result.trace.cost.ns_per_ray()));
        binary_trees.push_back(result.cost(result.binary_ns_per_ray()));
    }
    return {predict(scene, "ns_per_ray", std::move(trees)),
            predict(scene, "binary_ns_per_ray", std::move(binary_trees))};
}

std::string prediction_report(std::span<const Prediction> predictions) {
    if (predictions.empty()) return fmt::format("no correlations: they need {} builders or more\n", kFewestPredicted);
    Table table(header("correlation with"));
    for (const Prediction& prediction : predictions)
        table.add_row(row(title_of(prediction.measurement), prediction.fits));
    return table.text();
}

std::string pooled_report(std::span<const Prediction> predictions) {
    const std::vector<Pool> pools = make_pools(predictions);
    if (pools.empty()) return {};
    Table table(header("correlation with"));
    for (const Pool& pool : pools) {
        const std::string title = title_of(pool.measurement);
        table.add_row(row(title + ", mean", pool.means));
        table.add_row(row(title + ", least", pool.minima));
        table.add_row(row(title + ", weights shared", pool.shared));
    }
    return fmt::format("over {} scenes: the best weights of each, and the best that all share\n{}",
                       pools.front().scene_count, table.text());
}

ordered_json to_json(std::span<const Prediction> predictions) {
    ordered_json scenes = ordered_json::array();
    for (const Prediction& prediction : predictions) {
        ordered_json& json =
            scenes.emplace_back(ordered_json{{"scene", prediction.scene}, {"measurement", prediction.measurement}});
        for (std::size_t i = 0; i < kAllTerms.size(); ++i)
            json[kAllTerms[i].name] = fit_json(kAllTerms[i], prediction.fits[i]);
    }
    ordered_json pooled = ordered_json::array();
    for (const Pool& pool : make_pools(predictions))
        pooled.push_back(pool_json(pool));
    return {{"scenes", std::move(scenes)}, {"pooled", std::move(pooled)}};
}

}  // namespace clbvh::tool
