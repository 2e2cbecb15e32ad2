#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "clbvh/core/ray.hpp"
#include "core/simd/always_inline.hpp"

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
    /// How vertices are moved and sheared: the axes that become x, y and z, and the factors of z.
    struct Shear {
        std::array<float, 3> origin;
        unsigned x, y, z;
        float factor_x, factor_y, factor_z;
    };

    explicit WatertightTest(const Ray& ray) noexcept : shear_(shear_of(ray)) {}

    [[nodiscard]] const Shear& shear() const noexcept { return shear_; }

    /// Where the line meets the triangle. Where a NaN comes in, t is NaN or there is nothing.
    [[nodiscard]] CLBVH_ALWAYS_INLINE std::optional<PlaneHit> meet(const TriangleVertices& triangle) const noexcept {
        const Sheared a = sheared(triangle.v0);
        const Sheared b = sheared(triangle.v1);
        const Sheared c = sheared(triangle.v2);
        const float u = edge(c.x, b.y, c.y, b.x);
        const float v = edge(a.x, c.y, a.y, c.x);
        const float w = edge(b.x, a.y, b.y, a.x);
        if ((u < 0.0f || v < 0.0f || w < 0.0f) && (u > 0.0f || v > 0.0f || w > 0.0f)) return std::nullopt;
        const float determinant = (u + v) + w;
        if (determinant == 0.0f) return std::nullopt;
        const float scaled_t = ((u * a.z) + (v * b.z)) + (w * c.z);
        return PlaneHit{scaled_t / determinant, v / determinant, w / determinant};
    }

private:
    struct Sheared {
        float x, y, z;
    };

    /// Where they lie: a copy that is indexed has to go through memory first.
    static const float* coordinates(const Vec3& v) noexcept {
        static_assert(sizeof(Vec3) == 3 * sizeof(float));
        return reinterpret_cast<const float*>(&v);
    }

    static Shear shear_of(const Ray& ray) noexcept {
        const float x_size = std::fabs(ray.direction.x), y_size = std::fabs(ray.direction.y);
        const float z_size = std::fabs(ray.direction.z);
        const bool is_y = y_size > x_size;
        const unsigned z = z_size > (is_y ? y_size : x_size) ? 2 : is_y ? 1 : 0;
        unsigned x = z == 2 ? 0 : z + 1;
        unsigned y = x == 2 ? 0 : x + 1;
        const float* const d = coordinates(ray.direction);
        if (d[z] < 0.0f) std::swap(x, y);
        return {{ray.origin.x, ray.origin.y, ray.origin.z}, x, y, z, d[x] / d[z], d[y] / d[z], 1.0f / d[z]};
    }

    [[nodiscard]] Sheared sheared(const Vec3& vertex) const noexcept {
        const Shear& s = shear_;
        const float* const p = coordinates(vertex);
        const float z = p[s.z] - s.origin[s.z];
        return {(p[s.x] - s.origin[s.x]) - s.factor_x * z, (p[s.y] - s.origin[s.y]) - s.factor_y * z, s.factor_z * z};
    }

    /// a * b - c * d. A difference of 0 means equal products: what is left are their rounding errors.
    [[nodiscard]] static float edge(float a, float b, float c, float d) noexcept {
        const float ab = a * b, cd = c * d;
        const float difference = ab - cd;
        if (difference != 0.0f) return difference;  // also where it is NaN
        return std::fma(a, b, -ab) - std::fma(c, d, -cd);
    }

    Shear shear_;
};

/// Moeller, Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection", of both sides.
class MollerTrumboreTest {
public:
    explicit MollerTrumboreTest(const Ray& ray) noexcept : origin_(ray.origin), direction_(ray.direction) {}

    /// Where the line meets the triangle. Where a NaN comes in, t is NaN or there is nothing.
    [[nodiscard]] CLBVH_ALWAYS_INLINE std::optional<PlaneHit> meet(const TriangleVertices& triangle) const noexcept {
        const Vec3 edge1 = difference(triangle.v1, triangle.v0);
        const Vec3 edge2 = difference(triangle.v2, triangle.v0);
        const Vec3 p = cross(direction_, edge2);
        const float determinant = dot(edge1, p);
        if (determinant == 0.0f) return std::nullopt;
        const float inverse = 1.0f / determinant;
        const Vec3 s = difference(origin_, triangle.v0);
        const Vec3 q = cross(s, edge1);
        const PlaneHit hit{dot(edge2, q) * inverse, dot(s, p) * inverse, dot(direction_, q) * inverse};
        if (!(hit.u >= 0.0f && hit.v >= 0.0f && hit.u + hit.v <= 1.0f)) return std::nullopt;
        return hit;
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
