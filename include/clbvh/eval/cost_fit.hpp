#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clbvh/export.h"

namespace clbvh {

/// One tree's metrics, and the measured cost of its rays. Any unit will do for the latter.
struct TreeCost {
    double sah = 0.0;       ///< sah_cost()
    double epo = 0.0;       ///< end_point_overlap()
    double lcv = 0.0;       ///< leaf_count_variability()
    double measured = 0.0;  ///< Nanoseconds per ray, for example.
};

/// How much EPO and LCV count beside SAH in (1 - alpha - beta) SAH + alpha EPO + beta LCV (Aila, Karras, Laine 2013,
/// equations 6 and 7). Both are 0 or more, and 1 together at most.
struct CostWeights {
    double alpha = 0.0;
    double beta = 0.0;
};

/// Which metrics a prediction is made of.
enum class CostTerms : std::uint8_t {
    sah,          ///< alpha = beta = 0.
    sah_epo,      ///< beta = 0: equation 6.
    sah_epo_lcv,  ///< Equation 7.
};

/// The weights that predict best, and how well they do.
struct CostFit {
    CostWeights weights;
    double correlation = 0.0;  ///< Between prediction and measurement: -1 to 1, where 1 is a straight line.
};

/// The sample Pearson correlation coefficient (equation 5). 0 where either side has no variance.
/// Throws Error(invalid_input) where the spans differ in length or a value is not finite.
[[nodiscard]] CLBVH_EVAL_API double correlation(std::span<const double> x, std::span<const double> y);

/// The cost that the weights predict for a tree, up to a straight line.
[[nodiscard]] CLBVH_EVAL_API double predicted_cost(const TreeCost& tree, const CostWeights& weights) noexcept;

/// The correlation of prediction and measurement over trees of one scene. Throws as correlation() does.
[[nodiscard]] CLBVH_EVAL_API double prediction_quality(std::span<const TreeCost> trees, const CostWeights& weights);

/// The weights with the highest correlation over the trees of one scene, of which there should be many more than
/// weights: exact, since it is a problem of least squares with weights >= 0. Of equals those of fewer terms.
/// Throws Error(invalid_input) where a value is not finite.
[[nodiscard]] CLBVH_EVAL_API CostFit fit_costs(std::span<const TreeCost> trees, CostTerms terms);

/// The weights, the same for all scenes, with the highest mean of the scenes' correlations, which is reported (Aila,
/// Karras, Laine 2013, section 4.3): searched on a grid of hundredths, then finer around its best point.
/// Throws Error(invalid_input) where a value is not finite.
[[nodiscard]] CLBVH_EVAL_API CostFit fit_costs(std::span<const std::vector<TreeCost>> scenes, CostTerms terms);

}  // namespace clbvh
