// Aila, Karras, Laine 2013, "On Quality Metrics of Bounding Volume Hierarchies", equations 5 to 7 and section 4.3.
#include "clbvh/eval/cost_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>

#include "clbvh/core/error.hpp"

namespace clbvh {
namespace {

/// Of SAH, EPO and LCV in this order.
using Weights = std::array<double, 3>;

/// Weights whose correlations differ by less are equally good.
constexpr double kEqual = 1e-12;

Weights metrics_of(const TreeCost& tree) {
    return {tree.sah, tree.epo, tree.lcv};
}

/// Deviations from the means, multiplied with each other and summed: all that correlations depend on.
struct Moments {
    std::array<Weights, 3> metrics{};  ///< Each metric with each.
    Weights with_measured{};           ///< Each metric with the measurements.
    double measured = 0.0;             ///< The measurements with themselves.

    [[nodiscard]] double correlation(const Weights& weights) const {
        double covariance = 0.0;
        double variance = 0.0;
        for (std::size_t i = 0; i < 3; ++i) {
            covariance += weights[i] * with_measured[i];
            for (std::size_t j = 0; j < 3; ++j)
                variance += weights[i] * weights[j] * metrics[i][j];
        }
        const double scale = std::sqrt(std::max(0.0, variance)) * std::sqrt(measured);
        return scale > 0.0 ? std::clamp(covariance / scale, -1.0, 1.0) : 0.0;
    }
};

Moments moments_of(std::span<const TreeCost> trees) {
    const auto count = static_cast<double>(trees.size());
    Weights means{};
    double measured_mean = 0.0;
    for (const TreeCost& tree : trees) {
        const Weights metrics = metrics_of(tree);
        for (std::size_t i = 0; i < 3; ++i)
            means[i] += metrics[i] / count;
        measured_mean += tree.measured / count;
    }
    Moments moments;
    for (const TreeCost& tree : trees) {
        const Weights metrics = metrics_of(tree);
        const double measured = tree.measured - measured_mean;
        for (std::size_t i = 0; i < 3; ++i) {
            moments.with_measured[i] += (metrics[i] - means[i]) * measured;
            for (std::size_t j = 0; j < 3; ++j)
                moments.metrics[i][j] += (metrics[i] - means[i]) * (metrics[j] - means[j]);
        }
        moments.measured += measured * measured;
    }
    return moments;
}

void require_finite(std::span<const TreeCost> trees) {
    for (std::size_t i = 0; i < trees.size(); ++i) {
        const TreeCost& tree = trees[i];
        if (std::isfinite(tree.sah) && std::isfinite(tree.epo) && std::isfinite(tree.lcv) &&
            std::isfinite(tree.measured))
            continue;
        throw Error(ErrorCode::invalid_input,
                    "tree " + std::to_string(i) + ": a cost is not finite; leave trees without measurements out");
    }
}

/// Least squares over some of the metrics, by elimination. Nothing where they depend on each other.
std::optional<Weights> solve(const Moments& moments, std::span<const std::size_t> terms) {
    const std::size_t count = terms.size();
    std::array<std::array<double, 4>, 3> rows{};
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t j = 0; j < count; ++j)
            rows[i][j] = moments.metrics[terms[i]][terms[j]];
        rows[i][count] = moments.with_measured[terms[i]];
    }
    for (std::size_t pivot = 0; pivot < count; ++pivot) {
        // A matrix of moments is positive definite where it can be inverted at all, and needs no search for pivots.
        if (!(rows[pivot][pivot] > kEqual * moments.metrics[terms[pivot]][terms[pivot]])) return std::nullopt;
        for (std::size_t i = 0; i < count; ++i) {
            if (i == pivot) continue;
            const double factor = rows[i][pivot] / rows[pivot][pivot];
            for (std::size_t j = pivot; j <= count; ++j)
                rows[i][j] -= factor * rows[pivot][j];
        }
    }
    Weights weights{};
    for (std::size_t i = 0; i < count; ++i)
        weights[terms[i]] = rows[i][count] / rows[i][i];
    return weights;
}

std::size_t term_count(CostTerms terms) {
    return static_cast<std::size_t>(terms) + 1;
}

CostWeights normalized(const Weights& weights) {
    const double sum = weights[0] + weights[1] + weights[2];
    return {weights[1] / sum, weights[2] / sum};
}

Weights weights_of(const CostWeights& weights) {
    return {1.0 - weights.alpha - weights.beta, weights.alpha, weights.beta};
}

/// The best so far of all that were offered.
class Best {
public:
    void offer(const CostWeights& weights, double correlation) {
        if (is_any_ && correlation <= fit_.correlation + kEqual) return;
        fit_ = {weights, correlation};
        is_any_ = true;
    }
    [[nodiscard]] const CostFit& fit() const { return fit_; }

private:
    CostFit fit_;
    bool is_any_ = false;
};

/// Correlation knows no scale, so the best weights are a least-squares solution whose weights are >= 0. At the best
/// some metrics have a weight above 0, and with those alone the solution is the same without the condition. Where
/// nothing correlates positively, one metric alone is best, and is among these.
CostFit best_of_scene(const Moments& moments, CostTerms terms) {
    Best best;
    const std::array<std::vector<std::size_t>, 7> subsets{{{0}, {1}, {2}, {0, 1}, {0, 2}, {1, 2}, {0, 1, 2}}};
    for (const std::vector<std::size_t>& subset : subsets) {
        if (subset.back() >= term_count(terms)) continue;
        Weights weights{};
        weights[subset.front()] = 1.0;
        if (subset.size() > 1) {
            const std::optional<Weights> solution = solve(moments, subset);
            const auto is_positive = [&](std::size_t term) { return (*solution)[term] > 0.0; };
            if (!solution || !std::ranges::all_of(subset, is_positive)) continue;
            weights = *solution;
        }
        best.offer(normalized(weights), moments.correlation(weights));
    }
    return best.fit();
}

/// The points centre + (i, j) * step that are weights, with i and j from -reach to reach.
void search_around(CostWeights centre, double step, int reach, CostTerms terms, std::span<const Moments> scenes,
                   Best& best) {
    const int alpha_reach = terms == CostTerms::sah ? 0 : reach;
    const int beta_reach = terms == CostTerms::sah_epo_lcv ? reach : 0;
    for (int i = -alpha_reach; i <= alpha_reach; ++i) {
        for (int j = -beta_reach; j <= beta_reach; ++j) {
            const CostWeights weights{centre.alpha + i * step, centre.beta + j * step};
            if (weights.alpha < 0.0 || weights.beta < 0.0 || weights.alpha + weights.beta > 1.0) continue;
            double sum = 0.0;
            for (const Moments& scene : scenes)
                sum += scene.correlation(weights_of(weights));
            best.offer(weights, sum / static_cast<double>(scenes.size()));
        }
    }
}

}  // namespace

double correlation(std::span<const double> x, std::span<const double> y) {
    if (x.size() != y.size()) {
        throw Error(ErrorCode::invalid_input, "a correlation is between as many values as values: " +
                                                  std::to_string(x.size()) + " are not " + std::to_string(y.size()));
    }
    std::vector<TreeCost> pairs(x.size());
    for (std::size_t i = 0; i < x.size(); ++i)
        pairs[i] = {x[i], 0.0, 0.0, y[i]};
    return prediction_quality(pairs, {});
}

double predicted_cost(const TreeCost& tree, const CostWeights& weights) noexcept {
    return (1.0 - weights.alpha - weights.beta) * tree.sah + weights.alpha * tree.epo + weights.beta * tree.lcv;
}

double prediction_quality(std::span<const TreeCost> trees, const CostWeights& weights) {
    require_finite(trees);
    return moments_of(trees).correlation(weights_of(weights));
}

CostFit fit_costs(std::span<const TreeCost> trees, CostTerms terms) {
    require_finite(trees);
    return best_of_scene(moments_of(trees), terms);
}

CostFit fit_costs(std::span<const std::vector<TreeCost>> scenes, CostTerms terms) {
    if (scenes.empty()) return {};
    std::vector<Moments> moments;
    for (const std::vector<TreeCost>& scene : scenes) {
        require_finite(scene);
        moments.push_back(moments_of(scene));
    }
    constexpr int kGrid = 100;
    constexpr int kFinerReach = 15;
    constexpr int kFinerGrids = 6;
    Best best;
    search_around({}, 1.0 / kGrid, kGrid, terms, moments, best);
    double step = 1.0 / kGrid;
    for (int grid = 0; grid < kFinerGrids; ++grid) {
        step *= 0.1;
        search_around(best.fit().weights, step, kFinerReach, terms, moments, best);
    }
    return best.fit();
}

}  // namespace clbvh
