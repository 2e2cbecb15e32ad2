#include "clbvh/eval/cost_fit.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/random.hpp"
#include "support/expect_error.hpp"
#include "support/published_costs.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

using Trees = std::vector<TreeCost>;

Trees published_trees(const PublishedScene& scene, const PublishedCosts& costs) {
    Trees trees;
    for (std::size_t i = 0; i < kPublishedBuilders; ++i)
        trees.push_back({scene.sah[i], scene.epo[i], scene.lcv[i], costs.ns_per_ray[i]});
    return trees;
}

std::vector<Trees> published_trees(PublishedCosts PublishedScene::*kind) {
    std::vector<Trees> scenes(kPublishedScenes.size());
    std::ranges::transform(kPublishedScenes, scenes.begin(),
                           [kind](const PublishedScene& scene) { return published_trees(scene, scene.*kind); });
    return scenes;
}

/// Equation 5 in long double, two sums at a time.
double correlation_oracle(const Trees& trees, double alpha, double beta) {
    const auto predicted = [&](const TreeCost& t) -> long double {
        return (1 - static_cast<long double>(alpha) - beta) * t.sah + alpha * static_cast<long double>(t.epo) +
               beta * static_cast<long double>(t.lcv);
    };
    const auto count = static_cast<long double>(trees.size());
    long double x = 0, y = 0, xx = 0, yy = 0, xy = 0;
    for (const TreeCost& tree : trees) {
        x += tree.measured / count;
        y += predicted(tree) / count;
    }
    for (const TreeCost& tree : trees) {
        xx += (tree.measured - x) * (tree.measured - x);
        yy += (predicted(tree) - y) * (predicted(tree) - y);
        xy += (tree.measured - x) * (predicted(tree) - y);
    }
    return static_cast<double>(xy / std::sqrt(xx * yy));
}

Trees random_trees(Random& random, std::size_t count) {
    Trees trees(count);
    for (TreeCost& tree : trees)
        tree = {random.between(10, 50), random.between(1, 20), random.between(1, 5), random.between(50, 90)};
    return trees;
}

/// The published digits are rounded, which moves a correlation by a thousandth, and the weights by two hundredths.
void check_published(const PublishedScene& scene, const PublishedCosts& published) {
    INFO(scene.name);
    const Trees trees = published_trees(scene, published);
    constexpr double kRounding = 0.0011;
    CHECK(std::abs(fit_costs(trees, CostTerms::sah).correlation - published.sah_correlation) < kRounding);
    const CostFit two = fit_costs(trees, CostTerms::sah_epo);
    CHECK(std::abs(two.correlation - published.sah_epo_correlation) < kRounding);
    CHECK(std::abs(two.weights.alpha - published.sah_epo_alpha) < 0.02);
    CHECK(two.weights.beta == 0.0);
    const CostFit three = fit_costs(trees, CostTerms::sah_epo_lcv);
    CHECK(std::abs(three.correlation - published.all_correlation) < kRounding);
    CHECK(std::abs(three.weights.alpha - published.all_alpha) < 0.02);
    CHECK(std::abs(three.weights.beta - published.all_beta) < 0.02);
}

/// Mean and minimum of the scenes' own best correlations, as table 2 has them.
struct Aggregate {
    double average = 0.0;
    double minimum = 1.0;
};

Aggregate aggregate(PublishedCosts PublishedScene::*kind, CostTerms terms) {
    Aggregate result;
    for (const Trees& trees : published_trees(kind)) {
        const double quality = fit_costs(trees, terms).correlation;
        result.average += quality / static_cast<double>(kPublishedScenes.size());
        result.minimum = std::min(result.minimum, quality);
    }
    return result;
}

}  // namespace

TEST_CASE("the published correlations and weights of 22 scenes come out of the published measurements") {
    for (const PublishedScene& scene : kPublishedScenes) {
        check_published(scene, scene.scalar);
        check_published(scene, scene.simd);
    }
}

TEST_CASE("so do the published averages and minima (table 2)") {
    const auto check = [](PublishedCosts PublishedScene::*kind, CostTerms terms, double average, double minimum) {
        const Aggregate result = aggregate(kind, terms);
        CHECK(result.average == Approx(average).margin(0.0007));
        CHECK(result.minimum == Approx(minimum).margin(0.0007));
    };
    check(&PublishedScene::scalar, CostTerms::sah, 0.915, 0.652);
    check(&PublishedScene::scalar, CostTerms::sah_epo, 0.994, 0.988);
    check(&PublishedScene::scalar, CostTerms::sah_epo_lcv, 0.996, 0.988);
    check(&PublishedScene::simd, CostTerms::sah, 0.933, 0.660);
    check(&PublishedScene::simd, CostTerms::sah_epo, 0.979, 0.907);
    check(&PublishedScene::simd, CostTerms::sah_epo_lcv, 0.993, 0.988);
}

TEST_CASE("so do the weights that are the same for all scenes (section 4.3)") {
    // The top is flat: the published weights are hundredths beside it, and as good to the fourth digit.
    const auto check = [](PublishedCosts PublishedScene::*kind, CostTerms terms, double quality,
                          const CostWeights& weights) {
        const std::vector<Trees> scenes = published_trees(kind);
        const CostFit fit = fit_costs(scenes, terms);
        CHECK(fit.correlation == Approx(quality).margin(0.0007));
        CHECK(fit.weights.alpha == Approx(weights.alpha).margin(0.021));
        CHECK(fit.weights.beta == Approx(weights.beta).margin(0.021));
        double published = 0.0;
        for (const Trees& trees : scenes)
            published += prediction_quality(trees, weights) / static_cast<double>(scenes.size());
        CHECK(published <= fit.correlation);
        CHECK(published > fit.correlation - 2e-4);
    };
    check(&PublishedScene::scalar, CostTerms::sah_epo, 0.980, {0.71, 0.0});
    check(&PublishedScene::simd, CostTerms::sah_epo_lcv, 0.981, {0.14, 0.76});
}

TEST_CASE("no weights of a fine grid are better than those that were found") {
    Random random(11);
    for (int trial = 0; trial < 60; ++trial) {
        std::vector<Trees> scenes;
        for (std::size_t i = 0; i <= random.below(3); ++i)
            scenes.push_back(random_trees(random, 3 + random.below(8)));
        const auto quality = [&scenes](double alpha, double beta) {
            double sum = 0.0;
            for (const Trees& trees : scenes)
                sum += correlation_oracle(trees, alpha, beta);
            return sum / static_cast<double>(scenes.size());
        };
        double best_two = -1.0, best_three = -1.0;
        for (int i = 0; i <= 60; ++i) {
            best_two = std::max(best_two, quality(i / 60.0, 0.0));
            for (int j = 0; i + j <= 60; ++j)
                best_three = std::max(best_three, quality(i / 60.0, j / 60.0));
        }
        const auto check = [&](const CostFit& fit, double best_of_grid) {
            const auto& [alpha, beta] = fit.weights;
            CHECK(alpha >= 0.0);
            CHECK(beta >= 0.0);
            CHECK(alpha + beta <= 1.0 + 1e-12);
            CHECK(fit.correlation == Approx(quality(alpha, beta)).margin(1e-9));
            // Means of several scenes may have several tops, of which the search's grid finds the highest but for this.
            CHECK(fit.correlation >= best_of_grid - (scenes.size() > 1 ? 1e-4 : 1e-9));
        };
        check(fit_costs(scenes, CostTerms::sah_epo), best_two);
        check(fit_costs(scenes, CostTerms::sah_epo_lcv), best_three);
        if (scenes.size() > 1) continue;
        check(fit_costs(scenes[0], CostTerms::sah_epo), best_two);
        check(fit_costs(scenes[0], CostTerms::sah_epo_lcv), best_three);
    }
}

TEST_CASE("weights that measurements were made with are found") {
    Random random(3);
    for (const CostWeights& weights : {CostWeights{0.3, 0.5}, CostWeights{0.0, 0.0}, CostWeights{1.0, 0.0},
                                       CostWeights{0.25, 0.0}, CostWeights{0.0, 0.9}}) {
        std::vector<Trees> scenes{random_trees(random, 9), random_trees(random, 5)};
        for (Trees& trees : scenes) {
            for (TreeCost& tree : trees)
                tree.measured = 7.0 + 3.0 * predicted_cost(tree, weights);
            const CostFit own = fit_costs(trees, CostTerms::sah_epo_lcv);
            CHECK(own.correlation == Approx(1.0).epsilon(1e-9));
            CHECK(own.weights.alpha == Approx(weights.alpha).margin(1e-6));
            CHECK(own.weights.beta == Approx(weights.beta).margin(1e-6));
        }
        const CostFit shared = fit_costs(scenes, CostTerms::sah_epo_lcv);
        CHECK(shared.weights.alpha == Approx(weights.alpha).margin(1e-4));
        CHECK(shared.weights.beta == Approx(weights.beta).margin(1e-4));
    }
}

TEST_CASE("correlations by hand") {
    const std::vector<double> up{1, 2, 3, 4};
    const std::vector<double> down{8, 6, 4, 2};
    const std::vector<double> flat{5, 5, 5, 5};
    const std::vector<double> other{1, 3, 2, 4};
    CHECK(correlation(up, up) == Approx(1.0));
    CHECK(correlation(up, down) == Approx(-1.0));
    CHECK(correlation(up, other) == Approx(0.8));
    CHECK(correlation(up, flat) == 0.0);
    CHECK(correlation(flat, up) == 0.0);
    CHECK(correlation({}, {}) == 0.0);
    expect_error(ErrorCode::invalid_input, {"4", "3"}, [&] { (void)correlation(up, std::span(other).first(3)); });
}

TEST_CASE("trees that tell nothing leave SAH alone, and costs that are not finite are refused") {
    for (const Trees& trees : {Trees{}, Trees{{1, 2, 3, 4}}, Trees(5, TreeCost{1, 2, 3, 4})}) {
        for (const CostTerms terms : {CostTerms::sah, CostTerms::sah_epo, CostTerms::sah_epo_lcv}) {
            const CostFit fit = fit_costs(trees, terms);
            CHECK(fit.correlation == 0.0);
            CHECK(fit.weights.alpha == 0.0);
            CHECK(fit.weights.beta == 0.0);
        }
    }
    CHECK(fit_costs(std::vector<Trees>{}, CostTerms::sah_epo).correlation == 0.0);
    Trees broken(3);
    broken[1].epo = std::numeric_limits<double>::quiet_NaN();
    expect_error(ErrorCode::invalid_input, {"tree 1"}, [&] { (void)fit_costs(broken, CostTerms::sah); });
    expect_error(ErrorCode::invalid_input, {"tree 1"},
                 [&] { (void)fit_costs(std::vector<Trees>{broken}, CostTerms::sah); });
}
