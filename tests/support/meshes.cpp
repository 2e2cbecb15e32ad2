#include "support/meshes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace clbvh::test {
namespace {

/// Uniform in [-extent, extent), from the generator's bits alone, so that every standard library gives the same.
float uniform(std::mt19937& random, float extent) {
    const auto bits = static_cast<std::uint32_t>(random() >> 8);
    return (static_cast<float>(bits) / 8388608.0f - 1.0f) * extent;
}

Vec3 uniform_point(std::mt19937& random, const Vec3& centre, float extent) {
    const float x = uniform(random, extent);
    const float y = uniform(random, extent);
    const float z = uniform(random, extent);
    return {centre.x + x, centre.y + y, centre.z + z};
}

void append_triangle(Mesh& mesh, const Vec3& a, const Vec3& b, const Vec3& c) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {a, b, c});
    mesh.triangles.push_back({first, first + 1, first + 2});
}

}  // namespace

Mesh random_triangles(std::size_t count, std::uint32_t seed) {
    std::mt19937 random(seed);
    Mesh mesh;
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3 centre = uniform_point(random, {}, 10.0f);
        const Vec3 a = uniform_point(random, centre, 0.5f);
        const Vec3 b = uniform_point(random, centre, 0.5f);
        const Vec3 c = uniform_point(random, centre, 0.5f);
        append_triangle(mesh, a, b, c);
    }
    return mesh;
}

Mesh coincident_triangles(std::size_t count) {
    Mesh mesh;
    for (std::size_t i = 0; i < count; ++i)
        append_triangle(mesh, {1, 2, 3}, {2, 2, 4}, {1, 3, 3});
    return mesh;
}

void deactivate_triangles(Mesh& mesh, std::size_t first, std::size_t step) {
    for (std::size_t i = first; i < mesh.triangles.size(); i += step) {
        mesh.vertices[mesh.triangles[i][i % 3]].y = std::numeric_limits<float>::quiet_NaN();
    }
}

Mesh scaled(Mesh mesh, float factor) {
    for (Vec3& v : mesh.vertices)
        v = {v.x * factor, v.y * factor, v.z * factor};
    return mesh;
}

float largest_scale(const Mesh& mesh) {
    float largest = 0.0f;
    for (const Vec3& v : mesh.vertices)
        largest = std::max({largest, std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    return std::exp2(std::floor(std::log2(kMaxCoordinate / largest)));
}

}  // namespace clbvh::test
