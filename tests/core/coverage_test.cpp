// The proof of coverage against its oracle: points sampled on triangles, looked for in every box.
#include "core/coverage.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <vector>

using namespace clbvh;

namespace {

using Corners = std::array<Vec3, 3>;

class Sampler {
public:
    explicit Sampler(std::uint32_t seed) : random_(seed) {}

    float between(float lower, float upper) { return std::uniform_real_distribution<float>(lower, upper)(random_); }
    Vec3 point(float size) { return {between(-size, size), between(-size, size), between(-size, size)}; }
    Corners triangle(float size) { return {point(size), point(size), point(size)}; }

    Vec3 point_on(const Corners& t) {
        double u = between(0, 1);
        double v = between(0, 1);
        if (u + v > 1) u = 1 - u, v = 1 - v;
        const auto mix = [&](float a, float b, float c) { return static_cast<float>(a + u * (b - a) + v * (c - a)); };
        return {mix(t[0].x, t[1].x, t[2].x), mix(t[0].y, t[1].y, t[2].y), mix(t[0].z, t[1].z, t[2].z)};
    }

private:
    std::mt19937 random_;
};

bool in_box(const Vec3& point, const Aabb& box, float slack) {
    return box.lower.x - slack <= point.x && point.x <= box.upper.x + slack && box.lower.y - slack <= point.y &&
           point.y <= box.upper.y + slack && box.lower.z - slack <= point.z && point.z <= box.upper.z + slack;
}

bool in_some_box(const Vec3& point, const std::vector<Aabb>& boxes, float slack) {
    return std::ranges::any_of(boxes, [&](const Aabb& box) { return in_box(point, box, slack); });
}

Aabb bounds_of(const Corners& t) {
    return merge(merge(Aabb{t[0], t[0]}, t[1]), t[2]);
}

/// Cells of a grid over the box, numbered so that neighbours share their faces to the bit.
std::vector<Aabb> grid(const Aabb& box, int cells) {
    const auto face = [&](float lower, float upper, int i) {
        return i == cells ? upper : lower + (upper - lower) * static_cast<float>(i) / static_cast<float>(cells);
    };
    std::vector<Aabb> result;
    for (int x = 0; x < cells; ++x) {
        for (int y = 0; y < cells; ++y) {
            for (int z = 0; z < cells; ++z) {
                const auto corner = [&](int dx, int dy, int dz) {
                    return Vec3{face(box.lower.x, box.upper.x, x + dx), face(box.lower.y, box.upper.y, y + dy),
                                face(box.lower.z, box.upper.z, z + dz)};
                };
                result.push_back({corner(0, 0, 0), corner(1, 1, 1)});
            }
        }
    }
    return result;
}

}  // namespace

TEST_CASE("a triangle is covered by its own box, and by nothing") {
    const Corners triangle{{{0, 0, 0}, {1, 0, 0.5f}, {0, 1, 1}}};
    CHECK_FALSE(find_uncovered_point(triangle, std::vector{bounds_of(triangle)}));
    CHECK(find_uncovered_point(triangle, {}));
}

TEST_CASE("coverage of random triangles by random boxes agrees with sampled points") {
    Sampler sampler(3);
    int covered = 0;
    for (int round = 0; round < 3000; ++round) {
        const Corners triangle = sampler.triangle(1);
        std::vector<Aabb> boxes;
        const int count = static_cast<int>(sampler.between(1, 12));
        for (int i = 0; i < count; ++i) {
            const Vec3 a = sampler.point(1.5f);
            const Vec3 b = sampler.point(1.5f);
            boxes.push_back({min(a, b), max(a, b)});
        }
        // One sampled point outside all boxes proves that the triangle is not covered ...
        bool missed = false;
        for (int i = 0; i < 200 && !missed; ++i)
            missed = !in_some_box(sampler.point_on(triangle), boxes, 1e-6f);
        const std::optional<Vec3> point = find_uncovered_point(triangle, boxes);
        if (missed) CHECK(point);
        // ... and so does the point that the proof itself names.
        if (point) CHECK_FALSE(in_some_box(*point, boxes, -1e-6f));
        if (!point) ++covered;
    }
    CHECK(covered > 30);
}

TEST_CASE("a grid of boxes covers a triangle until one that holds a piece of it is taken away") {
    Sampler sampler(5);
    for (const float size : {1.0f, 1e18f, 1e-39f}) {
        for (int round = 0; round < 40; ++round) {
            const Corners triangle = sampler.triangle(size);
            std::vector<Aabb> boxes = grid(bounds_of(triangle), 2 + round % 7);
            std::shuffle(boxes.begin(), boxes.end(), std::mt19937(7));
            CHECK_FALSE(find_uncovered_point(triangle, boxes));
            const Vec3 point = sampler.point_on(triangle);
            std::erase_if(boxes, [&](const Aabb& box) { return in_box(point, box, size * 1e-6f); });
            CHECK(find_uncovered_point(triangle, boxes));
        }
    }
}

TEST_CASE("a gap of one unit in the last place is a lost part, none is not") {
    const Corners triangle{{{100, 0, 0}, {101, 0, 0.3f}, {100, 1, 0.7f}}};
    const Aabb whole = bounds_of(triangle);
    Aabb left = whole;
    Aabb right = whole;
    left.upper.x = 100.3f;
    right.lower.x = left.upper.x;
    CHECK_FALSE(find_uncovered_point(triangle, std::vector{left, right}));
    right.lower.x = std::nextafter(left.upper.x, 1000.0f);
    const std::optional<Vec3> point = find_uncovered_point(triangle, std::vector{left, right});
    REQUIRE(point);
    CHECK(point->x == Approx(100.3f).epsilon(1e-7));
}

TEST_CASE("triangles without an area are covered or not like all others") {
    const Corners needle{{{0, 0, 0}, {1, 1, 1}, {0.5f, 0.5f, 0.5f}}};
    const Corners spot{{{2, 2, 2}, {2, 2, 2}, {2, 2, 2}}};
    const Aabb first{{0, 0, 0}, {0.4f, 0.4f, 0.4f}};
    const Aabb second{{0.4f, 0.4f, 0.4f}, {1, 1, 1}};
    CHECK_FALSE(find_uncovered_point(needle, std::vector{second, first}));
    const std::optional<Vec3> point = find_uncovered_point(needle, std::vector{first});
    REQUIRE(point);
    CHECK(point->x > 0.4f);
    CHECK_FALSE(find_uncovered_point(spot, std::vector{Aabb{{2, 2, 2}, {2, 2, 2}}}));
    CHECK(find_uncovered_point(spot, std::vector{first, second}));
}

TEST_CASE("a triangle in very many leaves is proven in no time that grows with their square") {
    const Corners triangle{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
    std::vector<Aabb> boxes;
    constexpr int cells = 512;  // at which corners are exact
    for (int x = 0; x < cells; ++x) {
        for (int y = 0; x + y < cells; ++y) {
            const auto at = [](int i) { return static_cast<float>(i) / cells; };
            boxes.push_back({{at(x), at(y), 0}, {at(x + 1), at(y + 1), 0}});
        }
    }
    CHECK_FALSE(find_uncovered_point(triangle, boxes));
    boxes.erase(boxes.begin() + 12345);
    CHECK(find_uncovered_point(triangle, boxes));
}

TEST_CASE("a box is covered by the parts that planes cut it into, and not without one of them") {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> unit(0.0f, 1.0f);
    for (int repeat = 0; repeat < 20; ++repeat) {
        const bool is_flat = repeat % 3 == 0;
        const Aabb whole{{-3, 1, 5}, {7, is_flat ? 1.0f : 4.0f, 5.5f}};
        std::vector<Aabb> parts{whole};
        while (parts.size() < 30) {
            Aabb& part = parts[random() % parts.size()];
            Aabb other = part;
            float Vec3::*const axis = std::array{&Vec3::x, &Vec3::z, is_flat ? &Vec3::x : &Vec3::y}[random() % 3];
            const float plane = part.lower.*axis + unit(random) * (part.upper.*axis - part.lower.*axis);
            if (!(part.lower.*axis < plane && plane < part.upper.*axis)) continue;
            part.upper.*axis = plane;
            other.lower.*axis = plane;
            parts.push_back(other);
        }
        std::shuffle(parts.begin(), parts.end(), random);
        CHECK_FALSE(find_uncovered_point(whole, parts));
        for (std::size_t i = 0; i < parts.size(); ++i) {
            std::vector<Aabb> without = parts;
            without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
            const std::optional<Vec3> point = find_uncovered_point(whole, without);
            REQUIRE(point);
            CHECK(merge(parts[i], *point) == parts[i]);
        }
    }
}
