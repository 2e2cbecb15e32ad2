#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "clbvh/io/scene.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using clbvh::test::expect_error;

namespace {

bool same(const Mesh& a, const Mesh& b) {
    return a.vertices == b.vertices && a.triangles == b.triangles;
}

std::vector<Aabb> boxes_of(const Mesh& mesh) {
    std::vector<Aabb> boxes;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        boxes.push_back(triangle_bounds(mesh, i));
    return boxes;
}

Aabb bounds_of(const Mesh& mesh) {
    Aabb bounds;
    for (const Aabb& box : boxes_of(mesh))
        bounds = merge(bounds, box);
    return bounds;
}

Vec3 extent_of(const Aabb& box) {
    return {box.upper.x - box.lower.x, box.upper.y - box.lower.y, box.upper.z - box.lower.z};
}

double distance(const Vec3& a, const Vec3& b) {
    return std::hypot(double{a.x} - b.x, double{a.y} - b.y, double{a.z} - b.z);
}

/// A triangle's edges, shortest first.
std::array<double, 3> edges_of(const Mesh& mesh, const Triangle& t) {
    const Vec3& a = mesh.vertices[t[0]];
    const Vec3& b = mesh.vertices[t[1]];
    const Vec3& c = mesh.vertices[t[2]];
    std::array<double, 3> edges{distance(a, b), distance(b, c), distance(c, a)};
    std::sort(edges.begin(), edges.end());
    return edges;
}

double area_of(const Mesh& mesh, const Triangle& t) {
    const auto [a, b, c] = edges_of(mesh, t);
    const double s = (a + b + c) / 2;
    return std::sqrt(std::max(0.0, s * (s - a) * (s - b) * (s - c)));
}

/// How many triangle centres fall into each cell of a grid over the scene.
std::vector<std::size_t> occupancy(const Mesh& mesh, std::size_t cells) {
    const Aabb bounds = bounds_of(mesh);
    const Vec3 extent = extent_of(bounds);
    std::vector<std::size_t> counts(cells * cells * cells);
    const auto cell = [cells](float lower, float upper, float start, float size) {
        return std::min(cells - 1,
                        static_cast<std::size_t>(static_cast<float>(cells) * ((lower + upper) / 2 - start) / size));
    };
    for (const Aabb& box : boxes_of(mesh)) {
        const std::size_t x = cell(box.lower.x, box.upper.x, bounds.lower.x, extent.x);
        const std::size_t y = cell(box.lower.y, box.upper.y, bounds.lower.y, extent.y);
        const std::size_t z = cell(box.lower.z, box.upper.z, bounds.lower.z, extent.z);
        ++counts[(z * cells + y) * cells + x];
    }
    return counts;
}

/// FNV-1a over everything in the mesh.
std::uint64_t fingerprint(const Mesh& mesh) {
    std::uint64_t hash = 0xCBF29CE484222325U;
    const auto add = [&hash](std::uint32_t word) { hash = (hash ^ word) * 0x100000001B3U; };
    for (const Vec3& v : mesh.vertices) {
        for (const float coordinate : {v.x, v.y, v.z}) {
            std::uint32_t bits = 0;
            std::memcpy(&bits, &coordinate, sizeof bits);
            add(bits);
        }
    }
    for (const Triangle& t : mesh.triangles)
        std::for_each(t.begin(), t.end(), add);
    return hash;
}

}  // namespace

TEST_CASE("every generator makes exactly the triangles it was asked for, and sound ones") {
    for (const SceneGeneratorInfo& generator : scene_generators()) {
        CHECK_FALSE(generator.description.empty());
        for (const std::uint64_t count :
             {0u, 1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u, 9u, 10u, 31u, 32u, 33u, 999u, 1000u, 1001u, 1003u, 4096u, 50001u}) {
            const Mesh mesh = generate_scene(generator.name, count);
            INFO(generator.name << " " << count);
            CHECK(mesh.triangles.size() == count);
            CHECK(check_mesh(mesh) == 0);
        }
    }
}

TEST_CASE("generated scenes depend on their seed and on nothing else") {
    for (const SceneGeneratorInfo& generator : scene_generators()) {
        INFO(generator.name);
        CHECK(same(generate_scene(generator.name, 2000, 5), generate_scene(generator.name, 2000, 5)));
        const bool seeded = generator.name != "sphere";
        CHECK(same(generate_scene(generator.name, 2000, 5), generate_scene(generator.name, 2000, 6)) != seeded);
    }
}

TEST_CASE("generated scenes are the same on every platform") {
    const std::map<std::string_view, std::uint64_t> expected{
        {"soup", 0xE38649D959E7696EU},   {"clustered", 0x60BA32E34E6D512AU}, {"terrain", 0xD263F75B5D8FCDBFU},
        {"city", 0x1855A43B89D48891U},   {"hair", 0x0C03CD6ABC6ED112U},      {"particles", 0xCAF98FF2CA9D2385U},
        {"line", 0x9F316B0B09230F95U},   {"sphere", 0x8AC83F43E4E4A901U},    {"outlier", 0xE5A43F36C08C144FU},
        {"planes", 0x5CCC13299F0A1DC4U}, {"sky", 0xA5804D540919CC80U},       {"two-objects", 0x89DC249743723B03U},
        {"planet", 0xA291F354523736B7U}, {"mixed", 0x39276F3A77BB290BU},     {"scanlike", 0x0F0BB7DA85BC018BU},
    };
    CHECK(expected.size() == scene_generators().size());
    for (const auto& [name, hash] : expected) {
        INFO(name);
        CHECK(fingerprint(generate_scene(name, 5000, 1)) == hash);
    }
}

TEST_CASE("a parameter says how far or how deep a scene is, and is refused out of its range") {
    const Mesh near = generate_scene("outlier:100", 50);
    CHECK(near.vertices[near.triangles.back()[0]].x == 100.0f);
    CHECK(same(generate_scene("outlier", 50), generate_scene("outlier:1e6", 50)));
    CHECK_FALSE(same(generate_scene("mixed:2", 50), generate_scene("mixed:3", 50)));
    for (const std::string name : {"outlier:", "outlier:far", "outlier:9", "outlier:1e13", "outlier:nan", "mixed:-1"}) {
        const std::string value = name.substr(name.find(':') + 1);
        expect_error(ErrorCode::invalid_input, {"\"" + value + "\""},
                     [&] { static_cast<void>(generate_scene(name, 50)); });
    }
    expect_error(ErrorCode::invalid_input, {"\"soup\" has no parameter"},
                 [] { static_cast<void>(generate_scene("soup:3", 50)); });
}

TEST_CASE("soup is uniform and its triangles are small") {
    const Mesh mesh = generate_scene("soup", 64000);
    const std::vector<std::size_t> counts = occupancy(mesh, 4);
    CHECK(*std::min_element(counts.begin(), counts.end()) > 800);
    CHECK(*std::max_element(counts.begin(), counts.end()) < 1200);
    for (const Aabb& box : boxes_of(mesh)) {
        const Vec3 extent = extent_of(box);
        if (std::max({extent.x, extent.y, extent.z}) > 0.026f) FAIL("a triangle is larger than its share of the cube");
    }
}

TEST_CASE("clustered leaves most of space empty, and crowds the rest unevenly") {
    std::vector<std::size_t> counts = occupancy(generate_scene("clustered", 100000), 16);
    const auto empty = std::count(counts.begin(), counts.end(), 0U);
    CHECK(static_cast<double>(empty) > 0.5 * static_cast<double>(counts.size()));
    CHECK(*std::max_element(counts.begin(), counts.end()) > 2000);
}

TEST_CASE("terrain is a connected heightfield of nearly equal triangles") {
    const Mesh mesh = generate_scene("terrain", 100000);
    CHECK(mesh.vertices.size() < 51000);
    const auto [least, most] =
        std::minmax_element(mesh.triangles.begin(), mesh.triangles.end(),
                            [&](const Triangle& a, const Triangle& b) { return area_of(mesh, a) < area_of(mesh, b); });
    CHECK(area_of(mesh, *most) < 1.5 * area_of(mesh, *least));
    const Vec3 extent = extent_of(bounds_of(mesh));
    CHECK(extent.y > 0.03f);
    CHECK(extent.y < 0.2f);
}

TEST_CASE("city has few huge triangles beside very many small ones") {
    std::vector<float> areas;
    for (const Aabb& box : boxes_of(generate_scene("city", 100000)))
        areas.push_back(half_area(box));
    std::sort(areas.begin(), areas.end());
    const float median = areas[areas.size() / 2];
    const auto huge = areas.end() - std::upper_bound(areas.begin(), areas.end(), 1000 * median);
    CHECK(areas.back() > 100000 * median);
    CHECK(huge > 2);
    CHECK(huge < 2000);
}

TEST_CASE("hair is long, thin, diagonal and overlapping") {
    const Mesh mesh = generate_scene("hair", 10000);
    for (const Triangle& triangle : mesh.triangles) {
        const auto edges = edges_of(mesh, triangle);
        if (edges[1] < 100 * edges[0]) FAIL("a triangle is not thin");
    }
    double volume = 0.0;
    for (const Aabb& box : boxes_of(mesh)) {
        const Vec3 extent = extent_of(box);
        if (std::min({extent.x, extent.y, extent.z}) < 0.1f) FAIL("a triangle is not diagonal");
        volume += double{extent.x} * extent.y * extent.z;
    }
    const Vec3 extent = extent_of(bounds_of(mesh));
    CHECK(volume > 50 * double{extent.x} * extent.y * extent.z);
}

TEST_CASE("particles come in groups with exactly the same box, one of them huge") {
    std::map<std::array<float, 6>, std::size_t> groups;
    for (const Aabb& box : boxes_of(generate_scene("particles", 100000)))
        ++groups[{box.lower.x, box.lower.y, box.lower.z, box.upper.x, box.upper.y, box.upper.z}];
    std::vector<std::size_t> sizes;
    sizes.reserve(groups.size());
    for (const auto& [box, size] : groups)
        sizes.push_back(size);
    std::sort(sizes.begin(), sizes.end());
    CHECK(sizes.back() == 50000);
    CHECK(sizes.size() > 100);
    CHECK(sizes.front() >= 256);
}

TEST_CASE("the centroids of line are collinear to the last bit") {
    const Mesh mesh = generate_scene("line", 10000);
    float least = 1.0f;
    float most = 0.0f;
    for (const Aabb& box : boxes_of(mesh)) {
        const Vec3 centre = doubled_centroid(box);
        if (centre.y != 0.0f || centre.z != 0.0f) FAIL("a centroid is off the line");
        if (std::min(extent_of(box).y, extent_of(box).z) <= 0.0f) FAIL("a box is flat");
        least = std::min(least, centre.x);
        most = std::max(most, centre.x);
    }
    CHECK(most - least > 1.9f);
}

namespace {

/// How often each directed edge occurs.
std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed_edges(const Mesh& mesh) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const Triangle& t : mesh.triangles) {
        for (std::size_t i = 0; i < 3; ++i)
            ++edges[{t[i], t[(i + 1) % 3]}];
    }
    return edges;
}

/// Edges that occur in one direction, but not once in the other.
int open_edges(const Mesh& mesh) {
    const auto edges = directed_edges(mesh);
    int open = 0;
    for (const auto& [edge, count] : edges) {
        const auto twin = edges.find({edge.second, edge.first});
        open += count != 1 || twin == edges.end();
    }
    return open;
}

}  // namespace

TEST_CASE("a sphere of an even count from 8 is closed, and misses one triangle where the count is odd") {
    for (const std::uint64_t count : {8u, 10u, 14u, 30u, 32u, 34u, 70u, 72u, 200u, 1000u, 9998u, 10000u}) {
        INFO(count);
        const Mesh mesh = generate_scene("sphere", count);
        CHECK(open_edges(mesh) == 0);
        // Euler: a closed surface without handles.
        CHECK(mesh.vertices.size() == count / 2 + 2);
        CHECK(open_edges(generate_scene("sphere", count + 1)) == 3);
    }
}

TEST_CASE("a sphere is round, and its triangles face outward") {
    const Mesh mesh = generate_scene("sphere", 1998);
    for (const Vec3& v : mesh.vertices) {
        if (std::abs(distance(v, {0, 0, 0}) - 1.0) > 1e-6) FAIL("a vertex is off the sphere");
    }
    for (const Triangle& t : mesh.triangles) {
        const Vec3& a = mesh.vertices[t[0]];
        const Vec3& b = mesh.vertices[t[1]];
        const Vec3& c = mesh.vertices[t[2]];
        const double volume = double{a.x} * (double{b.y} * c.z - double{b.z} * c.y) +
                              double{a.y} * (double{b.z} * c.x - double{b.x} * c.z) +
                              double{a.z} * (double{b.x} * c.y - double{b.y} * c.x);
        if (volume <= 0) FAIL("a triangle faces inward");
    }
}
