#include "trace/brute_force.hpp"

#include <array>
#include <cstddef>

namespace clbvh::test {
namespace {

using Double3 = std::array<double, 3>;

Double3 wide(const Vec3& v) {
    return {v.x, v.y, v.z};
}

Double3 minus(const Double3& a, const Double3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

double dot(const Double3& a, const Double3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Double3 cross(const Double3& a, const Double3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Takes the triangle where the ray meets it before `hit`: Cramer's rule.
void try_triangle(const Mesh& mesh, std::uint32_t index, const Ray& ray, Hit& hit) {
    const Triangle& triangle = mesh.triangles[index];
    const Double3 v0 = wide(mesh.vertices[triangle[0]]);
    const Double3 e1 = minus(wide(mesh.vertices[triangle[1]]), v0);
    const Double3 e2 = minus(wide(mesh.vertices[triangle[2]]), v0);
    const Double3 direction = wide(ray.direction);
    const Double3 from = minus(wide(ray.origin), v0);
    const Double3 normal = cross(e1, e2);
    const double determinant = -dot(direction, normal);
    if (determinant == 0.0) return;
    const Double3 moment = cross(from, direction);
    const double t = dot(from, normal) / determinant;
    const double u = dot(e2, moment) / determinant;
    const double v = -dot(e1, moment) / determinant;
    if (!(u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= ray.t_min && t <= ray.t_max)) return;
    if (static_cast<float>(t) < hit.t)
        hit = {static_cast<float>(t), static_cast<float>(u), static_cast<float>(v), index};
}

}  // namespace

ClosestHits brute_force(const Mesh& mesh) {
    return [&mesh](std::span<const Ray> rays, std::span<Hit> hits) {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            hits[i] = Hit{};
            for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
                try_triangle(mesh, t, rays[i], hits[i]);
        }
    };
}

Mesh box_mesh(const Aabb& box) {
    Mesh mesh;
    for (std::uint32_t corner = 0; corner < 8; ++corner) {
        mesh.vertices.push_back({(corner & 1U) != 0 ? box.upper.x : box.lower.x,
                                 (corner & 2U) != 0 ? box.upper.y : box.lower.y,
                                 (corner & 4U) != 0 ? box.upper.z : box.lower.z});
    }
    mesh.triangles = {{0, 1, 3}, {0, 3, 2}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                      {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 3, 7}, {1, 7, 5}};
    return mesh;
}

Mesh ground_mesh(float half_width) {
    const float w = half_width;
    return {{{-w, 0, -w}, {w, 0, -w}, {w, 0, w}, {-w, 0, w}}, {{0, 1, 2}, {0, 2, 3}}};
}

}  // namespace clbvh::test
