#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "cli/progress_bar.hpp"
#include "measure/ray_cost.hpp"
#include "measure/rounds.hpp"

using namespace clbvh;
using namespace clbvh::tool;

namespace {

/// Every ray hits at one distance, or a first few of each call at another.
class FakeEngine final : public RayEngine {
public:
    explicit FakeEngine(float distance, std::size_t others = 0) : distance_(distance), others_(others) {}

    [[nodiscard]] std::size_t rays_at_once() const override { return 1000; }
    void closest(std::span<const Ray>, std::span<Hit> hits, std::span<RayCounts>) override {
        Hit hit;
        hit.primitive = 0;
        hit.t = distance_;
        std::ranges::fill(hits, hit);
        for (Hit& other : hits.first(others_))
            other.t = 2.0f * distance_;
    }
    void any(std::span<const Ray>, std::span<std::uint8_t> is_hit, std::span<RayCounts>) override {
        std::ranges::fill(is_hit, distance_ > 1.0f ? std::uint8_t{0} : std::uint8_t{1});
    }
    void visits(std::span<const Ray>, std::span<RayCounts>) override {}

private:
    float distance_;
    std::size_t others_;
};

std::vector<std::uint64_t> mismatches(RayKind kind, std::vector<FakeEngine*> engines, RayEngine& reference) {
    std::vector<RayEntrant> entrants;
    for (FakeEngine* engine : engines)
        entrants.push_back({"an engine", engine});
    ProgressBar bar;
    RoundsProgress progress("a test", bar);
    std::vector<std::uint64_t> counts;
    for (const RayCost& cost : measure_rays(entrants, reference, {kind, std::vector<Ray>(10)}, 1, progress))
        counts.push_back(cost.mismatches);
    return counts;
}

}  // namespace

TEST_CASE("answers are compared with the reference's, each time that they are given: counted and not") {
    FakeEngine right(1.0f);
    FakeEngine partly(1.0f, 3);
    FakeEngine wrong(2.0f);
    using Counts = std::vector<std::uint64_t>;
    CHECK(mismatches(RayKind::diffuse, {&right, &partly, &wrong}, right) == Counts{0, 2 * 3, 2 * 10});
    CHECK(mismatches(RayKind::diffuse, {&wrong, &wrong}, right) == Counts{2 * 10, 2 * 10});
    CHECK(mismatches(RayKind::shadow, {&right, &wrong}, right) == Counts{0, 2 * 10});
    CHECK(mismatches(RayKind::shadow, {&wrong}, right) == Counts{2 * 10});
}
