#include "io/wide_scenes.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "io/mesh_pieces.hpp"
#include "io/sphere.hpp"

namespace clbvh::io {
namespace {

constexpr float kFarAway = 1000.0f;  // how much larger surroundings are

Mesh reserved(std::uint64_t count) {
    Mesh mesh;
    mesh.vertices.reserve(3 * count);
    mesh.triangles.reserve(count);
    return mesh;
}

/// Appends `count` triangles that fill a cube with this least corner and edge.
void push_cube(Mesh& mesh, std::uint64_t count, Random& random, const Vec3& corner, float edge) {
    const float half_size = edge * half_share(count);
    for (std::uint64_t i = 0; i < count; ++i)
        push_random_triangle(mesh, random, corner + edge * random.in_cube(0, 1), half_size);
}

/// Appends a sphere around `centre` of `count` triangles.
void push_sphere(Mesh& mesh, std::uint64_t count, const Vec3& centre, float radius) {
    const Mesh sphere = make_sphere(count);
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const Vec3& vertex : sphere.vertices)
        mesh.vertices.push_back(centre + radius * vertex);
    for (const Triangle& triangle : sphere.triangles)
        mesh.triangles.push_back({first + triangle[0], first + triangle[1], first + triangle[2]});
}

/// A plane wave over space, as bumps are made of: arcs of parabolas, which are the same on every platform.
struct Wave {
    Vec3 direction;  // in waves a unit
    float phase = 0.0f;
    float height = 0.0f;

    [[nodiscard]] float at(const Vec3& place) const {
        const float turns = dot(direction, place) + phase;
        const float rest = turns - std::floor(turns);
        return height * rest * (1 - rest);
    }
};

}  // namespace

Mesh make_outlier(std::uint64_t count, std::uint64_t seed, double distance) {
    Random random(seed);
    Mesh mesh = reserved(count);
    if (count == 0) return mesh;
    push_cube(mesh, count - 1, random, {0, 0, 0}, 1);
    const auto d = static_cast<float>(distance);
    const float size = std::max(0.01f, d * 0x1p-20f);  // so that its corners differ
    push_triangle(mesh, {d, d, d}, {d + size, d, d}, {d, d + size, d});
    return mesh;
}

Mesh make_planes(std::uint64_t count, std::uint64_t seed) {
    Random random(seed);
    Mesh mesh = reserved(count);
    const Vec3 corner{-kFarAway / 2, 0, -kFarAway / 2};
    push_quad(mesh, count, corner, {kFarAway, 0, 0}, {0, 0, kFarAway});
    push_quad(mesh, count, corner, {kFarAway, 0, 0}, {0, kFarAway, 0});
    push_quad(mesh, count, corner, {0, 0, kFarAway}, {0, kFarAway, 0});
    push_cube(mesh, count - mesh.triangles.size(), random, {0, 0.1f, 0}, 1);
    return mesh;
}

Mesh make_sky(std::uint64_t count, std::uint64_t seed) {
    Random random(seed);
    Mesh mesh = reserved(count);
    push_sphere(mesh, count / 16 / 2 * 2, {0, 0, 0}, kFarAway);
    push_cube(mesh, count - mesh.triangles.size(), random, {0, 0, 0}, 1);
    return mesh;
}

Mesh make_two_objects(std::uint64_t count, std::uint64_t seed, double distance) {
    Random random(seed);
    Mesh mesh = reserved(count);
    push_cube(mesh, count - count / 2, random, {0, 0, 0}, 1);
    push_cube(mesh, count / 2, random, {static_cast<float>(distance), 0, 0}, 1);
    return mesh;
}

Mesh make_planet(std::uint64_t count, std::uint64_t seed) {
    constexpr float kRadius = 6371000.0f;
    constexpr float kTown = 2000.0f;
    Random random(seed);
    Mesh mesh = reserved(count);
    push_sphere(mesh, count / 4 / 2 * 2, {0, 0, 0}, kRadius);
    while (mesh.triangles.size() < count) {
        const Vec3 place = kTown * random.in_cube(-0.5f, 0.5f);
        const Vec3 size{random.between(8, 30), random.between(5, 60), random.between(8, 30)};
        push_building(mesh, count, {place.x, kRadius - 5, place.z}, size);
    }
    return mesh;
}

Mesh make_mixed(std::uint64_t count, std::uint64_t seed, double orders) {
    Random random(seed);
    Mesh mesh = reserved(count);
    const auto steps = static_cast<std::uint64_t>(orders);
    float edge = 1.0f;
    for (std::uint64_t k = 0; k <= steps; ++k, edge *= 0.1f) {
        const std::uint64_t share = k < steps ? count / (steps + 1) : count - mesh.triangles.size();
        push_cube(mesh, share, random, {0, 0, 0}, edge);
    }
    return mesh;
}

Mesh make_scanlike(std::uint64_t count, std::uint64_t seed) {
    Random random(seed);
    std::array<Wave, 24> waves;
    float frequency = 0.5f;
    for (Wave& wave : waves) {
        wave = {frequency * random.in_cube(-1, 1), random.unit(), 0.15f / frequency};
        frequency *= 1.2f;
    }
    Mesh mesh = make_sphere(count);
    for (Vec3& vertex : mesh.vertices) {
        float radius = 1.0f;
        for (const Wave& wave : waves)
            radius += wave.at(vertex);
        vertex = radius * vertex;
    }
    return mesh;
}

}  // namespace clbvh::io
