#include "clbvh/metrics/lcv.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/random.hpp"

using namespace clbvh;

TEST_CASE("leaf count variability is the standard deviation of leaves per ray") {
    CHECK(leaf_count_variability({}) == 0.0);
    CHECK(leaf_count_variability(std::vector<RayCounts>(7, {1, 5, 9})) == 0.0);
    CHECK(leaf_count_variability(std::vector<RayCounts>{{0, 1, 0}, {9, 3, 9}}) == 1.0);
    CHECK(leaf_count_variability(std::vector<RayCounts>{
              {0, 2, 0}, {0, 4, 0}, {0, 4, 0}, {0, 4, 0}, {0, 5, 0}, {0, 5, 0}, {0, 7, 0}, {0, 9, 0}}) == 2.0);
    // As equation 4 has it.
    Random random(1);
    std::vector<RayCounts> rays(10000);
    long double sum = 0, squares = 0;
    for (RayCounts& ray : rays) {
        ray.leaves = random.below(1000);
        sum += ray.leaves;
        squares += static_cast<long double>(ray.leaves) * ray.leaves;
    }
    const auto expected = static_cast<double>(std::sqrt(squares / 10000 - sum / 10000 * (sum / 10000)));
    CHECK(leaf_count_variability(rays) == Approx(expected).epsilon(1e-12));
    // A constant that is added to all changes nothing, however large.
    for (RayCounts& ray : rays)
        ray.leaves += 4000000000U;
    CHECK(leaf_count_variability(rays) == Approx(expected).epsilon(1e-12));
}

TEST_CASE("mean counts are means") {
    CHECK(mean_counts({}).steps() == 0.0);
    const MeanCounts means = mean_counts(std::vector<RayCounts>{{1, 2, 3}, {4, 0, 0}, {4294967295U, 1, 0}});
    CHECK(means.inner_nodes == 4294967300.0 / 3);
    CHECK(means.leaves == 1.0);
    CHECK(means.triangles == 1.0);
    CHECK(means.steps() == means.inner_nodes + 1.0);
}
