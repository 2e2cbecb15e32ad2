#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "report/metrics_result.hpp"

namespace clbvh::tool {

/// Below so many trees a correlation means nothing: two always lie on a line, and there are two weights.
inline constexpr std::size_t kFewestPredicted = 4;

/// How well SAH, SAH with EPO, and both with LCV predict one measurement over the trees of one scene.
struct Prediction {
    std::string scene;
    std::string measurement;      ///< Its field in JSON: "ns_per_ray", "binary_ns_per_ray", ...
    std::vector<TreeCost> trees;  ///< The trees whose cost is predicted.
    std::array<CostFit, 3> fits;  ///< In the order of CostTerms.
};

/// Of one measurement over the trees of one scene, of which there should be kFewestPredicted.
[[nodiscard]] Prediction predict(std::string scene, std::string measurement, std::vector<TreeCost> trees);

/// One for each measurement; none where there are fewer than kFewestPredicted trees.
[[nodiscard]] std::vector<Prediction> predict(std::span<const MetricsResult> of_scene);

/// The table of one scene, as the last columns of table 1 of Aila, Karras, Laine 2013; a word instead where there is
/// none.
[[nodiscard]] std::string prediction_report(std::span<const Prediction> predictions);

/// Over several scenes: the mean and the least of their correlations, as in table 2, and weights that all scenes share,
/// as in section 4.3. Empty for fewer than two scenes.
[[nodiscard]] std::string pooled_report(std::span<const Prediction> predictions);

/// {"scenes": [...], "pooled": [...]}
[[nodiscard]] nlohmann::ordered_json to_json(std::span<const Prediction> predictions);

}  // namespace clbvh::tool
