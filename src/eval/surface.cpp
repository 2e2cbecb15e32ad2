#include "clbvh/eval/surface.hpp"

#include <algorithm>
#include <cmath>

#include "clbvh/core/vector.hpp"
#include "eval/double3.hpp"

namespace clbvh {
namespace {

constexpr float kOffset = 0x1p-18f;

/// In double precision: in float32 the product of two short edges would vanish. Its scale is of no matter.
Vec3 triangle_normal(const Vec3& v0, const Vec3& v1, const Vec3& v2) {
    const Double3 a = difference(v1, v0);
    const Double3 b = difference(v2, v0);
    const Double3 n = cross(a, b);
    const double largest = std::max({std::abs(n[0]), std::abs(n[1]), std::abs(n[2])});
    if (largest == 0.0) return {};
    return normalized(
        {static_cast<float>(n[0] / largest), static_cast<float>(n[1] / largest), static_cast<float>(n[2] / largest)});
}

float largest_coordinate(const Vec3& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

}  // namespace

SurfacePoint surface_point(const MeshView& mesh, const Ray& ray, const Hit& hit) noexcept {
    const Triangle triangle = mesh.triangle(hit.primitive);
    const Vec3 v0 = mesh.vertex(triangle[0]);
    const Vec3 v1 = mesh.vertex(triangle[1]);
    const Vec3 v2 = mesh.vertex(triangle[2]);
    Vec3 normal = triangle_normal(v0, v1, v2);
    if (dot(normal, ray.direction) > 0.0f) normal = -normal;
    const float scale = std::max({largest_coordinate(v0), largest_coordinate(v1), largest_coordinate(v2)});
    const Vec3 position = ((1.0f - hit.u - hit.v) * v0 + hit.u * v1) + hit.v * v2;
    return {position + (kOffset * scale) * normal, normal};
}

Vec3 cosine_direction(const Vec3& normal, float x, float y) noexcept {
    // Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
    const float sign = std::copysign(1.0f, normal.z);
    const float a = -1.0f / (sign + normal.z);
    const float b = normal.x * normal.y * a;
    const Vec3 tangent{1.0f + sign * normal.x * normal.x * a, sign * b, -sign * normal.x};
    const Vec3 bitangent{b, sign + normal.y * normal.y * a, -normal.y};
    const float z = std::sqrt(std::max(0.0f, 1.0f - (x * x + y * y)));
    return normalized((x * tangent + y * bitangent) + z * normal);
}

}  // namespace clbvh
