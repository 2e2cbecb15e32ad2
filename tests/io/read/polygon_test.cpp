#include "io/read/polygon.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

using namespace clbvh;
using io::PolygonCut;

namespace {

using Outline = std::vector<std::pair<double, double>>;

/// A polygon in the plane z = 2x - y + 7, moved by `shift` along x, y and z.
struct Cut {
    Mesh mesh;
    PolygonCut cut;
};

Cut cut(const Outline& outline, float shift = 0.0f) {
    Cut result{};
    for (const auto& [x, y] : outline) {
        result.mesh.vertices.push_back(
            {static_cast<float>(x) + shift, static_cast<float>(y) + shift, static_cast<float>(2 * x - y + 7) + shift});
    }
    std::vector<std::uint32_t> corners(outline.size());
    std::iota(corners.begin(), corners.end(), 0U);
    result.cut = io::append_polygon(corners, result.mesh);
    return result;
}

/// Twice the area from above, signed.
double turned(const Mesh& mesh, const Triangle& t) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    return (double{b.x} - a.x) * (double{c.y} - a.y) - (double{b.y} - a.y) * (double{c.x} - a.x);
}

/// The same of the whole polygon, by its outline.
double turned(const Mesh& mesh) {
    double sum = 0.0;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        const Vec3 &a = mesh.vertices[i], &b = mesh.vertices[(i + 1) % mesh.vertices.size()];
        const Vec3& o = mesh.vertices[0];
        sum += (double{a.x} - o.x) * (double{b.y} - o.y) - (double{a.y} - o.y) * (double{b.x} - o.x);
    }
    return sum;
}

/// A clean cut has as many triangles as corners less two, all turned as the polygon is, and their areas sum up to its:
/// so they cover it, and do not overlap.
void check_clean(const Outline& outline, float shift = 0.0f) {
    const Cut result = cut(outline, shift);
    INFO(outline.size() << " corners, shift " << shift);
    CHECK(result.cut == PolygonCut::clean);
    REQUIRE(result.mesh.triangles.size() == outline.size() - 2);
    const double whole = turned(result.mesh);
    double sum = 0.0;
    int against = 0;
    for (const Triangle& triangle : result.mesh.triangles) {
        sum += turned(result.mesh, triangle);
        against += turned(result.mesh, triangle) * whole < 0 ? 1 : 0;
    }
    CHECK(against == 0);
    CHECK(sum == Approx(whole).epsilon(1e-9));
}

Outline reversed(const Outline& outline) {
    return {outline.rbegin(), outline.rend()};
}

Outline gear(int teeth) {
    Outline outline;
    for (int i = 0; i < 2 * teeth; ++i) {
        const double angle = M_PI * i / teeth, radius = i % 2 == 0 ? 1.0 : 0.5;
        outline.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
    }
    return outline;
}

Outline spiral(int steps, double turns) {
    Outline outline;
    for (const int side : {0, 1}) {
        for (int i = 0; i < steps; ++i) {
            const int at = side == 0 ? i : steps - 1 - i;
            const double angle = 2 * M_PI * turns * at / steps, radius = 1 + angle + (side == 0 ? 0.0 : 3.0);
            outline.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
        }
    }
    return outline;
}

Outline comb(int teeth) {
    Outline outline{{0.0, -1.0}, {double(teeth), -1.0}, {double(teeth), 0.0}};
    for (int i = teeth - 1; i >= 0; --i) {
        outline.emplace_back(i + 0.5, 20.0);
        outline.emplace_back(i, 0.0);
    }
    return outline;
}

}  // namespace

TEST_CASE("concave polygons of any number of corners are cut cleanly") {
    for (const int teeth : {2, 3, 50, 502, 5000})
        check_clean(gear(teeth));
    check_clean(spiral(100, 3));
    check_clean(spiral(20000, 30));
    for (const int teeth : {1, 2, 10, 1000})
        check_clean(comb(teeth));
}

TEST_CASE("a polygon may run either way, begin anywhere, and lie far from the origin") {
    check_clean(reversed(gear(30)));
    check_clean(reversed(spiral(500, 4)));
    Outline l{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
    for (std::size_t first = 0; first < l.size(); ++first) {
        for (const float shift : {0.0f, 1e5f, -1048576.0f}) {
            check_clean(l, shift);
            check_clean(reversed(l), shift);
        }
        std::rotate(l.begin(), l.begin() + 1, l.end());
    }
}

TEST_CASE("random polygons around a point are cut cleanly") {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> radius(0.05, 1.0);
    for (int round = 0; round < 200; ++round) {
        Outline outline;
        const int corners = 4 + round;
        for (int i = 0; i < corners; ++i) {
            const double r = radius(random), angle = 2 * M_PI * i / corners;
            outline.emplace_back(r * std::cos(angle), r * std::sin(angle));
        }
        check_clean(outline);
    }
}

TEST_CASE("corners in line, twice, or where a hole is cut open are taken") {
    check_clean({{0, 0}, {1, 0}, {2, 0}, {3, 0}, {3, 3}, {2, 1}, {1, 1}, {0, 3}});
    check_clean({{0, 0}, {0, 0}, {2, 0}, {1, 0.5}, {1, 0.5}, {2, 2}, {0, 2}});
    // A square with a square hole, joined by an edge that is there twice.
    check_clean({{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0}, {1, 1}, {1, 3}, {3, 3}, {3, 1}, {1, 1}});
}

TEST_CASE("what cannot be cut cleanly becomes a fan, and says so") {
    const Outline star{{0, 1}, {0.59, -0.81}, {-0.95, 0.31}, {0.95, 0.31}, {-0.59, -0.81}};
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(0.0, 1.0);
    Outline tangle;
    for (int i = 0; i < 1000; ++i)
        tangle.emplace_back(place(random), place(random));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const Outline& outline : {star, tangle, Outline{{0, 0}, {1, 0}, {nan, 1}, {0, 1}}}) {
        const Cut result = cut(outline);
        CHECK(result.cut == PolygonCut::fan);
        CHECK(result.mesh.triangles.size() == outline.size() - 2);
    }
}

TEST_CASE("cutting a large polygon can be cancelled") {
    struct Cancelled : std::runtime_error {
        Cancelled() : std::runtime_error("cancelled") {}
    };
    Mesh mesh;
    std::vector<std::uint32_t> corners;
    for (const auto& [x, y] : spiral(40000, 20)) {
        corners.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
        mesh.vertices.push_back({static_cast<float>(x), static_cast<float>(y), 0.0f});
    }
    CHECK_THROWS_AS(io::append_polygon(corners, mesh, [] { throw Cancelled(); }), Cancelled);
}

TEST_CASE("a clean cut covers no more than the polygon, whatever the polygon") {
    // Small grids, so that corners meet corners and edges, and edges fold back.
    std::mt19937 random(11);
    const auto below = [&](unsigned end) { return static_cast<unsigned>(random() % end); };
    int clean = 0, wrong = 0;
    for (int round = 0; round < 50000; ++round) {
        Mesh mesh;
        const unsigned corners = 3 + below(10), side = 2 + below(8);
        for (unsigned i = 0; i < corners; ++i)
            mesh.vertices.push_back({static_cast<float>(below(side)), static_cast<float>(below(side)), 0.0f});
        std::vector<std::uint32_t> indices(corners);
        std::iota(indices.begin(), indices.end(), 0U);
        const PolygonCut result = io::append_polygon(indices, mesh);
        double sum = 0.0, covered = 0.0;
        for (const Triangle& triangle : mesh.triangles) {
            sum += turned(mesh, triangle);
            covered += std::abs(turned(mesh, triangle));
        }
        // Areas of whole numbers are exact.
        wrong += mesh.triangles.size() != corners - 2 || sum != turned(mesh) ? 1 : 0;
        if (result == PolygonCut::fan) continue;
        ++clean;
        wrong += covered != std::abs(sum) ? 1 : 0;
    }
    CHECK(wrong == 0);
    CHECK(clean > 10000);
}
