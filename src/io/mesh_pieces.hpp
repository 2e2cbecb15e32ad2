#pragma once

#include <cmath>
#include <cstdint>

#include "clbvh/core/mesh.hpp"
#include "clbvh/core/vector.hpp"
#include "core/random.hpp"

/// What generated scenes are put together from.
namespace clbvh::io {

inline std::uint32_t push_vertex(Mesh& mesh, const Vec3& vertex) {
    mesh.vertices.push_back(vertex);
    return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
}

inline void push_triangle(Mesh& mesh, const Vec3& a, const Vec3& b, const Vec3& c) {
    const std::uint32_t first = push_vertex(mesh, a);
    push_vertex(mesh, b);
    push_vertex(mesh, c);
    mesh.triangles.push_back({first, first + 1, first + 2});
}

/// A triangle with its corners at random in a cube around `centre`.
inline void push_random_triangle(Mesh& mesh, Random& random, const Vec3& centre, float half_size) {
    const Vec3 a = centre + random.in_cube(-half_size, half_size);
    const Vec3 b = centre + random.in_cube(-half_size, half_size);
    const Vec3 c = centre + random.in_cube(-half_size, half_size);
    push_triangle(mesh, a, b, c);
}

/// Appends the two triangles of a parallelogram, as far as there is room below `count`.
inline void push_quad(Mesh& mesh, std::uint64_t count, const Vec3& corner, const Vec3& along, const Vec3& across) {
    const Vec3 opposite = corner + along + across;
    if (mesh.triangles.size() < count) push_triangle(mesh, corner, corner + along, opposite);
    if (mesh.triangles.size() < count) push_triangle(mesh, corner, opposite, corner + across);
}

/// The walls and the roof of a building whose least corner is `at`.
inline void push_building(Mesh& mesh, std::uint64_t count, const Vec3& at, const Vec3& size) {
    const Vec3 x{size.x, 0, 0};
    const Vec3 y{0, size.y, 0};
    const Vec3 z{0, 0, size.z};
    push_quad(mesh, count, at, x, y);
    push_quad(mesh, count, at + z, x, y);
    push_quad(mesh, count, at, z, y);
    push_quad(mesh, count, at + x, z, y);
    push_quad(mesh, count, at + y, x, z);
}

/// The least n > 0 with n * n >= value.
inline std::uint32_t square_root_up(std::uint64_t value) {
    std::uint64_t root = 1;
    while (root * root < value)
        ++root;
    return static_cast<std::uint32_t>(root);
}

/// The least n > 0 with n * n * n >= value.
inline std::uint32_t cube_root_up(std::uint64_t value) {
    std::uint64_t root = 1;
    while (root * root * root < value)
        ++root;
    return static_cast<std::uint32_t>(root);
}

/// Half the edge of a cube's share of the unit cube, where `count` of them fill it.
inline float half_share(std::uint64_t count) {
    return 0.5f / static_cast<float>(cube_root_up(count));
}

}  // namespace clbvh::io
