#include "clbvh/optimize/rebuild_policy.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

using clbvh::RebuildPolicy;

namespace {

/// A motion: rises[k] is what a frame costs more, as a part of a fresh tree's, k frames after a build at frame `begin`.
using Motion = double (*)(std::size_t begin, std::size_t frame);

constexpr std::size_t kFrames = 400;
constexpr double kBuild = 30.0, kTrace = 10.0;

double cost_of_policy(Motion motion) {
    RebuildPolicy policy(kBuild, kTrace);
    double cost = kBuild;
    std::size_t begin = 0;
    for (std::size_t frame = 0; frame < kFrames; ++frame) {
        if (policy.should_rebuild(motion(begin, frame))) {
            begin = frame;
            cost += kBuild;
            policy.rebuilt(kBuild, kTrace);
        }
        cost += kTrace * (motion(begin, frame) - 1.0);
    }
    return cost;
}

/// The least that builds and losses can cost together, by dynamic programming over the frames at which is built.
double least_cost(Motion motion) {
    std::vector<double> least(kFrames + 1, 1e30);
    least[0] = 0.0;
    for (std::size_t begin = 0; begin < kFrames; ++begin) {
        double cost = least[begin] + kBuild;
        for (std::size_t frame = begin; frame < kFrames; ++frame) {
            cost += kTrace * (motion(begin, frame) - 1.0);
            least[frame + 1] = std::min(least[frame + 1], cost);
        }
    }
    return least[kFrames];
}

}  // namespace

TEST_CASE("the rebuild policy costs at most about twice what the best moments would") {
    const Motion motions[] = {
        [](std::size_t, std::size_t) { return 1.0; },
        [](std::size_t begin, std::size_t frame) { return 1.0 + 0.02 * static_cast<double>(frame - begin); },
        [](std::size_t begin, std::size_t frame) { return 1.0 + 0.3 * std::sqrt(static_cast<double>(frame - begin)); },
        [](std::size_t begin, std::size_t frame) { return frame / 50 != begin / 50 ? 3.0 : 1.0; },
        [](std::size_t begin, std::size_t frame) { return 1.0 + 5.0 * static_cast<double>(frame - begin); },
    };
    for (const Motion motion : motions) {
        const double cost = cost_of_policy(motion), least = least_cost(motion);
        CHECK(cost >= least - 1e-9);
        CHECK(cost <= 2.0 * least + kBuild);
    }
}

TEST_CASE("the rebuild policy builds when the loss is a build's cost, and not before") {
    RebuildPolicy policy(10.0, 4.0);
    CHECK_FALSE(policy.should_rebuild(1.0));
    CHECK_FALSE(policy.should_rebuild(0.5));
    CHECK_FALSE(policy.should_rebuild(std::numeric_limits<double>::quiet_NaN()));
    CHECK(policy.loss_ms() == 0.0);
    CHECK_FALSE(policy.should_rebuild(2.0));
    CHECK_FALSE(policy.should_rebuild(2.0));
    CHECK(policy.should_rebuild(1.5));
    CHECK(policy.loss_ms() == 10.0);
    CHECK(policy.should_rebuild(1.0));
    policy.rebuilt(-1.0, 4.0);
    CHECK_FALSE(policy.should_rebuild(1.0));
    CHECK(policy.should_rebuild(1.1));
}
