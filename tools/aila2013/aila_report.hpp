#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "aila2013/aila_scene.hpp"
#include "report/cost_prediction.hpp"

namespace clbvh::tool {

/// How well SAH, EPO and LCV predict what was measured: "ns_per_ray", "binary_ns_per_ray" and, where the device traced,
/// "device_ns_per_ray" and "device_binary_ns_per_ray"; and "cost_per_ray", what rays visit at the costs of SAH. None
/// where there are fewer than kFewestPredicted trees.
[[nodiscard]] std::vector<Prediction> predict(const AilaScene& scene);

/// The table of one scene as the paper lays it out: builders are columns, and correlations stand behind them.
[[nodiscard]] std::string aila_report(const AilaScene& scene, std::span<const Prediction> predictions);

/// An array with the fields of `metrics` for each builder, of rays on the host; then what its tree was made by, its
/// `build_ms`, and where the device traced what that measured.
[[nodiscard]] nlohmann::ordered_json to_json(const AilaScene& scene);

}  // namespace clbvh::tool
