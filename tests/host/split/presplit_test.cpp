// Splitting leaves no bad edge, no crack and no gap, whatever the mesh, and stays within its budget.
#include "host/split/presplit.hpp"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "clbvh/io/scene.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

using Point = std::array<double, 3>;

Point point_of(const Vec3& v) {
    return {v.x, v.y, v.z};
}

std::array<Point, 3> corners_of(const Mesh& mesh, std::size_t triangle) {
    const Triangle& t = mesh.triangles[triangle];
    return {point_of(mesh.vertices[t[0]]), point_of(mesh.vertices[t[1]]), point_of(mesh.vertices[t[2]])};
}

Point normal_of(const Mesh& mesh, std::size_t triangle) {
    const auto [a, b, c] = corners_of(mesh, triangle);
    const Point u{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    const Point v{c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}

double volume_of(const Aabb& box) {
    return (double{box.upper.x} - box.lower.x) * (double{box.upper.y} - box.lower.y) *
           (double{box.upper.z} - box.lower.z);
}

double scene_volume(const Mesh& mesh) {
    Aabb box;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        box = merge(box, triangle_bounds(mesh, i));
    return volume_of(box);
}

double largest_edge_volume(const Mesh& mesh) {
    double largest = 0.0;
    for (const Triangle& t : mesh.triangles) {
        for (std::size_t i = 0; i < 3; ++i) {
            const Aabb point{mesh.vertices[t[i]], mesh.vertices[t[i]]};
            largest = std::max(largest, volume_of(merge(point, mesh.vertices[t[(i + 1) % 3]])));
        }
    }
    return largest;
}

bool same(const PresplitMesh& a, const PresplitMesh& b) {
    return a.mesh.vertices == b.mesh.vertices && a.mesh.triangles == b.mesh.triangles && a.source == b.source;
}

/// The boxes that builders get.
host::PartBoxes split_to_boxes(const Mesh& mesh, const PresplitConfig& config) {
    const ProgressCallback no_progress;
    host::HostStages stages(no_progress);
    stages.begin("presplit", 0.0, 1.0);
    host::PartBoxes parts;
    host::presplit(mesh, config, stages, parts);
    return parts;
}

bool contains(const Aabb& box, const Point& p, double slack) {
    const auto within = [slack](double lower, double value, double upper) {
        return lower - slack <= value && value <= upper + slack;
    };
    return within(box.lower.x, p[0], box.upper.x) && within(box.lower.y, p[1], box.upper.y) &&
           within(box.lower.z, p[2], box.upper.z);
}

/// A mesh of few large triangles, moved and scaled.
Mesh large_triangles(std::size_t count, std::uint32_t seed, double scale, double offset) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
    Mesh mesh;
    for (std::uint32_t i = 0; i < 3 * count; ++i) {
        const double x = scale * coordinate(random) + offset;
        const double y = scale * coordinate(random) - offset;
        const double z = scale * coordinate(random);
        mesh.vertices.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
        if (i % 3 == 2) mesh.triangles.push_back({i - 2, i - 1, i});
    }
    return mesh;
}

/// A closed surface without an edge along an axis.
Mesh skewed_sphere(std::uint64_t count) {
    Mesh mesh = generate_scene("sphere", count);
    for (Vec3& v : mesh.vertices)
        v = {v.x + 0.3f * v.y - 0.2f * v.z, v.y - 0.4f * v.x + 0.1f * v.z, v.z + 0.5f * v.x + 0.2f * v.y};
    return mesh;
}

constexpr float kLargestBudget = 64.0f;

}  // namespace

TEST_CASE("no edge of a part is above the threshold, and parts tile their triangle") {
    for (const std::uint32_t level : {1u, 5u, 9u}) {
        const Mesh mesh = large_triangles(50, level, 3.0, 1.0);
        const auto [parts, source] = presplit(mesh, {level, kLargestBudget});
        CHECK(largest_edge_volume(parts) <= std::ldexp(scene_volume(mesh), -static_cast<int>(level)) * (1 + 1e-5));
        REQUIRE(source.size() == parts.triangles.size());
        CHECK(source.size() > level * mesh.triangles.size() / 2);
        CHECK(std::is_sorted(source.begin(), source.end()));
        CHECK(std::equal(mesh.vertices.begin(), mesh.vertices.end(), parts.vertices.begin()));

        std::vector<Point> sums(mesh.triangles.size(), Point{});
        std::vector<double> areas(mesh.triangles.size());
        for (std::size_t i = 0; i < parts.triangles.size(); ++i) {
            const Point normal = normal_of(parts, i);
            for (std::size_t axis = 0; axis < 3; ++axis)
                sums[source[i]][axis] += normal[axis];
            areas[source[i]] += std::hypot(normal[0], normal[1], normal[2]);
        }
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
            const Point normal = normal_of(mesh, i);
            const double area = std::hypot(normal[0], normal[1], normal[2]);
            CHECK(areas[i] == Approx(area).epsilon(1e-4));  // an overlap would add up to more
            CHECK(std::hypot(sums[i][0] - normal[0], sums[i][1] - normal[1], sums[i][2] - normal[2]) < 1e-4 * area);
        }
    }
}

TEST_CASE("a closed surface stays closed: each edge has one partner, of the same points") {
    for (const std::uint64_t count : {8u, 50u, 200u, 2000u}) {
        for (const std::uint32_t level : {5u, 14u, 20u}) {
            for (const float budget : {1.5f, 3.0f, kLargestBudget}) {
                INFO(count << " triangles, level " << level << ", budget " << budget);
                const Mesh parts = presplit(skewed_sphere(count), {level, budget}).mesh;
                std::map<std::pair<Point, Point>, int> edges;
                for (const Triangle& t : parts.triangles) {
                    for (std::size_t i = 0; i < 3; ++i) {
                        const Point a = point_of(parts.vertices[t[i]]);
                        const Point b = point_of(parts.vertices[t[(i + 1) % 3]]);
                        ++edges[{a, b}];
                        --edges[{b, a}];
                    }
                }
                std::size_t open = 0;
                for (const auto& [edge, balance] : edges)
                    open += balance != 0 ? 1 : 0;
                CHECK(open == 0);
                if (level == 20 && budget == kLargestBudget) CHECK(parts.triangles.size() > 2 * count);
            }
        }
    }
}

TEST_CASE("the budget takes the highest level that fits, for the whole mesh") {
    const Mesh mesh = generate_scene("hair", 500);
    std::vector<PresplitMesh> of_level;
    for (std::uint32_t level = 1; level <= 14; ++level)
        of_level.push_back(presplit(mesh, {level, kLargestBudget}));
    CHECK(of_level.back().source.size() > 8 * mesh.triangles.size());
    for (const float budget : {1.0f, 1.01f, 2.0f, 3.5f, 8.0f, 20.0f}) {
        const PresplitMesh result = presplit(mesh, {14, budget});
        const auto most = static_cast<std::size_t>(budget * 500.0f);
        const auto fits = [most](const PresplitMesh& candidate) { return candidate.source.size() <= most; };
        const auto best = std::find_if(of_level.rbegin(), of_level.rend(), fits);
        INFO("budget " << budget << ": " << result.source.size());
        CHECK(fits(result));
        CHECK(same(result, best == of_level.rend() ? presplit(mesh, {14, 1.0f}) : *best));
    }
    CHECK(presplit(mesh, {14, 1.0f}).source.size() == mesh.triangles.size());
    CHECK(presplit(mesh, {40, 16.0f}).source.size() <= 16 * mesh.triangles.size());
}

TEST_CASE("meshes without volume, or without triangles, are left alone") {
    Mesh flat = random_triangles(300);
    for (Vec3& v : flat.vertices)
        v.z = 3.0f;
    Mesh point = coincident_triangles(10);
    for (Vec3& v : point.vertices)
        v = {1, 2, 3};
    for (const Mesh& mesh : {Mesh{}, flat, point}) {
        const PresplitMesh result = presplit(mesh, {40, kLargestBudget});
        CHECK(result.mesh.vertices == mesh.vertices);
        CHECK(result.mesh.triangles == mesh.triangles);
        CHECK(split_to_boxes(mesh, {40, kLargestBudget}).source == result.source);
    }
}

TEST_CASE("inactive triangles stay in the mesh, and are not among the boxes") {
    Mesh mesh = large_triangles(40, 3, 1.0, 0.0);
    deactivate_triangles(mesh, 0, 4);
    const PresplitMesh result = presplit(mesh, {6, kLargestBudget});
    std::size_t inactive = 0;
    for (std::size_t i = 0; i < result.source.size(); ++i) {
        if (!is_inactive(result.mesh, i)) continue;
        CHECK(result.mesh.triangles[i] == mesh.triangles[result.source[i]]);
        ++inactive;
    }
    CHECK(inactive == 10);
    const host::PartBoxes parts = split_to_boxes(mesh, {6, kLargestBudget});
    CHECK(parts.source.size() == result.source.size() - 10);
    CHECK(check_boxes(parts.boxes) == 0);
}

TEST_CASE("the boxes of the parts cover the triangle, and nothing outside its box") {
    struct Case {
        double scale;
        double offset;
    };
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    for (const Case& c : {Case{1.0, 0.0}, Case{1.0, 1e6}, Case{1e18, 0.0}, Case{1e-18, 0.0}, Case{1e-43, 0.0},
                          Case{3.0, 1e9}, Case{1e-30, 1.0}}) {
        const Mesh mesh = large_triangles(30, 5, c.scale, c.offset);
        const host::PartBoxes parts = split_to_boxes(mesh, {12, kLargestBudget});
        INFO("scale " << c.scale << ", offset " << c.offset << ", parts " << parts.source.size());
        std::size_t first = 0;
        for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
            std::size_t end = first;
            while (end < parts.source.size() && parts.source[end] == i)
                ++end;
            REQUIRE(end > first);
            const Aabb whole = triangle_bounds(mesh, i);
            for (std::size_t part = first; part < end; ++part)
                CHECK(merge(whole, parts.boxes[part]) == whole);
            if (end == first + 1) CHECK(parts.boxes[first] == whole);
            const auto [a, b, d] = corners_of(mesh, i);
            for (int sample = 0; sample < 300; ++sample) {
                // Many samples on the edges, where parts meet.
                const double u = sample % 3 == 0 ? 0.5 : uniform(random);
                const double v = sample % 2 == 0 ? 0.0 : uniform(random) * (1.0 - u);
                Point p;
                double largest = 0.0;
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    p[axis] = (1.0 - u - v) * a[axis] + u * b[axis] + v * d[axis];
                    largest = std::max({largest, std::abs(a[axis]), std::abs(b[axis]), std::abs(d[axis])});
                }
                bool covered = false;
                for (std::size_t part = first; part < end && !covered; ++part)
                    covered = contains(parts.boxes[part], p, largest * 0x1p-51);  // the sample's error
                REQUIRE(covered);
            }
            first = end;
        }
        CHECK(first == parts.source.size());
        if (scene_volume(mesh) > 0.0) CHECK(parts.source.size() > 10 * mesh.triangles.size());
    }
}

TEST_CASE("the boxes of the parts overlap where a midpoint had to be rounded") {
    // The middle of the edge from a to b lies 2^-61 beyond x = 0.5 + 2^-24, which double precision cannot say. Shortly
    // before it, towards b, the edge has points that are beyond this x, too, and below y = 0.5.
    const Vec3 a{1.0f + 0x1p-23f, 1, 1};
    const Vec3 b{0x1p-60f, 0, 0};
    Mesh mesh;
    mesh.vertices = {a, b, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}};
    const host::PartBoxes parts = split_to_boxes(mesh, {2, kLargestBudget});
    REQUIRE(parts.boxes.size() == 2);
    const auto has_such_points = [](const Aabb& box) {
        constexpr float x = 0.5f + 0x1p-24f;
        return box.lower.x <= x && box.upper.x > x && box.lower.y < 0.5f && box.upper.y >= 0.5f;
    };
    CHECK(std::ranges::any_of(parts.boxes, has_such_points));
}

TEST_CASE("presplit gives the same bytes on any number of threads, and in memory that was used before") {
    const Mesh mesh = generate_scene("hair", 20000);
    const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 8);
    const PresplitMesh expected = tbb::task_arena(1).execute([&] { return presplit(mesh); });
    CHECK(expected.source.size() > 3 * mesh.triangles.size());
    for (const int threads : {2, 4, 7}) {
        tbb::task_arena arena(threads);
        CHECK(same(arena.execute([&] { return presplit(mesh); }), expected));
    }
    const ProgressCallback no_progress;
    host::HostStages stages(no_progress);
    host::PartBoxes reused = split_to_boxes(generate_scene("hair", 30000), {});
    stages.begin("presplit", 0.0, 1.0);
    host::presplit(mesh, {}, stages, reused);
    const host::PartBoxes fresh = split_to_boxes(mesh, {});
    CHECK(reused.boxes == fresh.boxes);
    CHECK(reused.source == fresh.source);
}

TEST_CASE("presplit refuses a config out of range by name, and a mesh that breaks the contract") {
    const Mesh mesh = random_triangles(10);
    const auto expect_refused = [&](const PresplitConfig& config, const std::string& message) {
        expect_error(ErrorCode::invalid_input, {message}, [&] { (void)presplit(mesh, config); });
    };
    expect_refused({0}, "level is 0; it must be 1 to 40");
    expect_refused({41}, "level is 41; it must be 1 to 40");
    expect_refused({14, 0.5f}, "triangle_budget is 0.5; it must be 1 to 64");
    expect_refused({14, std::numeric_limits<float>::quiet_NaN()}, "triangle_budget is nan; it must be 1 to 64");
    Mesh bad = mesh;
    bad.triangles[4][1] = 30;
    expect_error(ErrorCode::invalid_input, {"triangle 4: vertex index 30"}, [&] { (void)presplit(bad); });
}
