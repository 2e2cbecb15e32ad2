#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "measure/sample.hpp"

using namespace clbvh::tool;

TEST_CASE("a sample's median is the middle, or the mean of the middle two") {
    const Sample odd = summarize({5.0, 1.0, 4.0});
    CHECK(odd.median == 4.0);
    CHECK(odd.min == 1.0);
    CHECK(odd.max == 5.0);
    CHECK(summarize({8.0, 1.0, 2.0, 4.0}).median == 3.0);
    CHECK(summarize({7.0}).median == 7.0);
    CHECK(summarize({}).median == 0.0);
}

TEST_CASE("the geometric mean is the root of the product") {
    CHECK(geometric_mean(std::array{2.0, 8.0}) == Approx(4.0));
    CHECK(geometric_mean(std::array{1.0, 2.0, 4.0}) == Approx(2.0));
    CHECK(std::isnan(geometric_mean({})));
}
