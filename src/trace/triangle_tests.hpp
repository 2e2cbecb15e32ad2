#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "clbvh/core/ray.hpp"

// How a ray is tested against one triangle. The arithmetic, in the order in which it is written here, is a contract:
// the vectors of the wide tree and the kernels on devices give the same bits.
namespace clbvh::trace {

/// A triangle as the tests read it.
struct TriangleVertices {
    Vec3 v0, v1, v2;
};

/// Where the ray's line meets the triangle's plane, and the weights of vertices 1 and 2 there.
struct PlaneHit {
    float t, u, v;
};

/// Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection": the triangle is moved and sheared so that the ray
/// starts at the origin and runs along an axis; then two triangles compute the same for an edge that they share. Where
/// an edge function is 0 after rounding, its sign is computed exactly, in place of the paper's double precision.
class WatertightTest {
public:
    explicit WatertightTest(const Ray& ray) noexcept : origin_(coordinates(ray.origin)) {
        const std::array<float, 3> d = coordinates(ray.direction);
        z_ = 0;
        if (std::fabs(d[1]) > std::fabs(d[z_])) z_ = 1;
        if (std::fabs(d[2]) > std::fabs(d[z_])) z_ = 2;
        x_ = (z_ + 1) % 3;
        y_ = (x_ + 1) % 3;
        if (d[z_] < 0.0f) std::swap(x_, y_);
        shear_x_ = d[x_] / d[z_];
        shear_y_ = d[y_] / d[z_];
        shear_z_ = 1.0f / d[z_];
    }

    /// True where the line meets the triangle; then `hit` is set. False wherever a NaN comes in.
    [[nodiscard]] bool meets(const TriangleVertices& triangle, PlaneHit& hit) const noexcept {
        const Sheared a = shear(triangle.v0);
        const Sheared b = shear(triangle.v1);
        const Sheared c = shear(triangle.v2);
        const float u = edge(c.x, b.y, c.y, b.x);
        const float v = edge(a.x, c.y, a.y, c.x);
        const float w = edge(b.x, a.y, b.y, a.x);
        if ((u < 0.0f || v < 0.0f || w < 0.0f) && (u > 0.0f || v > 0.0f || w > 0.0f)) return false;
        const float determinant = (u + v) + w;
        if (determinant == 0.0f) return false;
        const float scaled_t = ((u * a.z) + (v * b.z)) + (w * c.z);
        hit = {scaled_t / determinant, v / determinant, w / determinant};
        return true;
    }

private:
    struct Sheared {
        float x, y, z;
    };

    static std::array<float, 3> coordinates(const Vec3& v) noexcept { return {v.x, v.y, v.z}; }

    [[nodiscard]] Sheared shear(const Vec3& vertex) const noexcept {
        const std::array<float, 3> p = coordinates(vertex);
        const float z = p[z_] - origin_[z_];
        return {(p[x_] - origin_[x_]) - shear_x_ * z, (p[y_] - origin_[y_]) - shear_y_ * z, shear_z_ * z};
    }

    /// a * b - c * d. A difference of 0 means equal products: what is left are their rounding errors.
    [[nodiscard]] static float edge(float a, float b, float c, float d) noexcept {
        const float ab = a * b, cd = c * d;
        const float difference = ab - cd;
        if (difference != 0.0f) return difference;  // also where it is NaN
        return std::fma(a, b, -ab) - std::fma(c, d, -cd);
    }

    std::array<float, 3> origin_;
    unsigned x_, y_, z_;
    float shear_x_, shear_y_, shear_z_;
};

/// Moeller, Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection", of both sides.
class MollerTrumboreTest {
public:
    explicit MollerTrumboreTest(const Ray& ray) noexcept : origin_(ray.origin), direction_(ray.direction) {}

    /// True where the line meets the triangle; then `hit` is set. False wherever a NaN comes in.
    [[nodiscard]] bool meets(const TriangleVertices& triangle, PlaneHit& hit) const noexcept {
        const Vec3 edge1 = difference(triangle.v1, triangle.v0);
        const Vec3 edge2 = difference(triangle.v2, triangle.v0);
        const Vec3 p = cross(direction_, edge2);
        const float determinant = dot(edge1, p);
        if (determinant == 0.0f) return false;
        const float inverse = 1.0f / determinant;
        const Vec3 s = difference(origin_, triangle.v0);
        const Vec3 q = cross(s, edge1);
        hit = {dot(edge2, q) * inverse, dot(s, p) * inverse, dot(direction_, q) * inverse};
        return hit.u >= 0.0f && hit.v >= 0.0f && hit.u + hit.v <= 1.0f;
    }

private:
    static Vec3 difference(const Vec3& a, const Vec3& b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    static Vec3 cross(const Vec3& a, const Vec3& b) noexcept {
        return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    }
    static float dot(const Vec3& a, const Vec3& b) noexcept { return (a.x * b.x + a.y * b.y) + a.z * b.z; }

    Vec3 origin_, direction_;
};

}  // namespace clbvh::trace
