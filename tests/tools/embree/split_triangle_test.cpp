#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <random>

#include "embree/split_triangle.hpp"

using namespace clbvh;
using namespace clbvh::tool;

namespace {

using Point = std::array<double, 3>;
using Corners = std::array<Vec3, 3>;

constexpr LaneBox kEverything{{-1e30f, -1e30f, -1e30f}, {1e30f, 1e30f, 1e30f}};

bool contains(const LaneBox& box, const Point& point) {
    for (int k = 0; k < 3; ++k) {
        if (point[static_cast<std::size_t>(k)] < double{box.lower[k]}) return false;
        if (point[static_cast<std::size_t>(k)] > double{box.upper[k]}) return false;
    }
    return true;
}

Point between(const Corners& t, double u, double v) {
    const double w = 1.0 - u - v;
    return {w * double{t[0].x} + u * double{t[1].x} + v * double{t[2].x},
            w * double{t[0].y} + u * double{t[1].y} + v * double{t[2].y},
            w * double{t[0].z} + u * double{t[1].z} + v * double{t[2].z}};
}

class Random {
public:
    float operator()(float scale) { return scale * std::uniform_real_distribution<float>(-1.0f, 1.0f)(engine_); }
    Vec3 point(float scale) { return {(*this)(scale), (*this)(scale), (*this)(scale)}; }
    double part() { return std::uniform_real_distribution<double>(0.0, 1.0)(engine_); }

private:
    std::mt19937 engine_{7};
};

}  // namespace

TEST_CASE("no point of a triangle is lost where it is split") {
    Random random;
    for (int i = 0; i < 3000; ++i) {
        const float scale = std::pow(10.0f, random(18.0f));
        const Corners t{random.point(scale), random.point(scale), random.point(scale)};
        const unsigned axis = static_cast<unsigned>(i) % 3;
        const float position = random(scale);
        const LaneBox box{{-0.7f * scale, -0.6f * scale, -0.8f * scale}, {0.8f * scale, 0.7f * scale, 0.6f * scale}};
        const SplitBounds split = split_triangle(t[0], t[1], t[2], box, axis, position);
        std::size_t inside = 0;
        std::size_t kept = 0;
        for (int sample = 0; sample < 50; ++sample) {
            const double u = random.part();
            const Point point = between(t, u, (1.0 - u) * random.part());
            if (!contains(box, point)) continue;
            ++inside;
            kept += contains(point[axis] <= double{position} ? split.left : split.right, point) ? 1 : 0;
        }
        REQUIRE(kept == inside);
    }
}

TEST_CASE("the parts of a split triangle are as small as they can be") {
    const Vec3 a{0, 0, 0};
    const Vec3 b{4, 0, 0};
    const Vec3 c{0, 4, 8};
    const SplitBounds split = split_triangle(a, b, c, kEverything, 0, 1.0f);
    const std::array<float, 6> expected_left{0, 0, 0, 1, 4, 8};
    const std::array<float, 6> expected_right{1, 0, 0, 4, 3, 6};
    for (int k = 0; k < 3; ++k) {
        const auto at = static_cast<std::size_t>(k);
        CHECK(split.left.lower[k] == Approx(expected_left[at]).margin(1e-5));
        CHECK(split.left.upper[k] == Approx(expected_left[at + 3]).margin(1e-5));
        CHECK(split.right.lower[k] == Approx(expected_right[at]).margin(1e-5));
        CHECK(split.right.upper[k] == Approx(expected_right[at + 3]).margin(1e-5));
    }
    CHECK(split.left.upper[0] == 1.0f);
    CHECK(split.right.lower[0] == 1.0f);
}

TEST_CASE("a triangle on one side of the plane leaves the other side empty") {
    const SplitBounds split = split_triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, kEverything, 1, 2.0f);
    CHECK(split.right.lower[1] > split.right.upper[1]);
    CHECK(split.left.upper[1] == 1.0f);
    const LaneBox low{{0, 0, 0}, {1, 0.25f, 0}};
    const SplitBounds cut = split_triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, low, 1, 0.5f);
    CHECK(cut.right.lower[1] > cut.right.upper[1]);
    CHECK(cut.left.upper[1] == 0.25f);
}
