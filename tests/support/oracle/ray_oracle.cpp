#include "support/oracle/ray_oracle.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>

#include "core/random.hpp"

namespace clbvh::test {
namespace {

using Point = std::array<float, 3>;

Point point(const Vec3& v) {
    return {v.x, v.y, v.z};
}

bool is_finite(const Point& p) {
    return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

/// a * b - c * d, with the sign of the exact value, and never -0. Products of floats are exact in double precision.
float edge_function(float a, float b, float c, float d) {
    const float rounded = a * b - c * d;
    if (rounded != 0.0f) return rounded;
    return static_cast<float>(static_cast<double>(a) * b - static_cast<double>(c) * d + 0.0);
}

/// Woop, Benthin, Wald 2013, appendix A, both sides hit.
std::optional<Hit> watertight(const std::array<Point, 3>& vertices, const Ray& ray) {
    const Point o = point(ray.origin), d = point(ray.direction);
    std::size_t kz = 0;
    for (std::size_t axis = 1; axis < 3; ++axis)
        if (std::abs(d[axis]) > std::abs(d[kz])) kz = axis;
    std::size_t kx = kz == 2 ? 0 : kz + 1;
    std::size_t ky = kx == 2 ? 0 : kx + 1;
    if (d[kz] < 0.0f) std::swap(kx, ky);
    const float sx = d[kx] / d[kz], sy = d[ky] / d[kz], sz = 1.0f / d[kz];
    std::array<float, 3> x{}, y{}, z{};
    for (std::size_t i = 0; i < 3; ++i) {
        const float depth = vertices[i][kz] - o[kz];
        x[i] = vertices[i][kx] - o[kx] - sx * depth;
        y[i] = vertices[i][ky] - o[ky] - sy * depth;
        z[i] = sz * depth;
    }
    const std::array<float, 3> weights = {edge_function(x[2], y[1], y[2], x[1]), edge_function(x[0], y[2], y[0], x[2]),
                                          edge_function(x[1], y[0], y[1], x[0])};
    const auto [least, most] = std::ranges::minmax(weights);
    if (least < 0.0f && most > 0.0f) return std::nullopt;
    const float sum = weights[0] + weights[1] + weights[2];
    if (sum == 0.0f) return std::nullopt;
    const float t = (weights[0] * z[0] + weights[1] * z[1] + weights[2] * z[2]) / sum;
    return Hit{t, weights[1] / sum, weights[2] / sum, 0};
}

Point cross(const Point& a, const Point& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

float dot(const Point& a, const Point& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Point minus(const Point& a, const Point& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// Moeller, Trumbore 1997, the variant without culling.
std::optional<Hit> moller_trumbore(const std::array<Point, 3>& vertices, const Ray& ray) {
    const Point edge1 = minus(vertices[1], vertices[0]), edge2 = minus(vertices[2], vertices[0]);
    const Point p = cross(point(ray.direction), edge2);
    const float determinant = dot(edge1, p);
    if (determinant == 0.0f) return std::nullopt;
    const float inverse = 1.0f / determinant;
    const Point to_origin = minus(point(ray.origin), vertices[0]);
    const float u = dot(to_origin, p) * inverse;
    if (!(u >= 0.0f)) return std::nullopt;
    const Point q = cross(to_origin, edge1);
    const float v = dot(point(ray.direction), q) * inverse;
    if (!(v >= 0.0f) || !(u + v <= 1.0f)) return std::nullopt;
    return Hit{dot(edge2, q) * inverse, u, v, 0};
}

Vec3 mix(const Vec3& a, const Vec3& b, float weight) {
    return {a.x + weight * (b.x - a.x), a.y + weight * (b.y - a.y), a.z + weight * (b.z - a.z)};
}

Vec3 from_to(const Vec3& a, const Vec3& b) {
    return {b.x - a.x, b.y - a.y, b.z - a.z};
}

/// Makes the rays of difficult_rays, one kind after the other.
class RayMaker {
public:
    RayMaker(const Mesh& mesh, std::uint64_t seed) : mesh_(mesh), random_(seed) {
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
            if (!is_inactive(mesh, i)) box_ = merge(box_, triangle_bounds(mesh, i));
        }
    }

    Ray make(std::size_t kind) {
        const Vec3 outside = in_box(-0.5f, 1.5f);
        const Vec3 inside = in_box(0.0f, 1.0f);
        switch (kind) {
            case 0: return towards(outside, inside);
            case 1: return towards(inside, outside);
            case 2: return {inside, 0.0f, axis(), infinity()};
            case 3: return {vertex(), 0.0f, axis(), infinity()};
            case 4: return {pick_coordinates(inside, vertex()), 0.0f, axis(), infinity()};
            case 5: return towards(outside, vertex());
            case 6: return towards(outside, on_edge());
            case 7: return along_edge(outside);
            case 8: return towards(on_triangle(), inside);
            case 9: return {inside, -1.0f, from_to(inside, outside), random_.unit()};
            case 10: return {outside, random_.unit(), from_to(outside, inside), 1.0f + random_.unit()};
            default: return in_plane();
        }
    }
    static constexpr std::size_t kKinds = 12;

private:
    static float infinity() { return std::numeric_limits<float>::infinity(); }
    static Ray towards(const Vec3& from, const Vec3& to) { return {from, 0.0f, from_to(from, to), infinity()}; }

    Vec3 in_box(float low, float high) {
        const Vec3 weights = random_.in_cube(low, high);
        return {box_.lower.x + weights.x * (box_.upper.x - box_.lower.x),
                box_.lower.y + weights.y * (box_.upper.y - box_.lower.y),
                box_.lower.z + weights.z * (box_.upper.z - box_.lower.z)};
    }
    /// One of the six, with zeros of either sign.
    Vec3 axis() {
        std::array<float, 3> d{};
        for (float& value : d)
            value = random_.below(2) == 0 ? 0.0f : -0.0f;
        d[random_.below(3)] = random_.below(2) == 0 ? 1.0f : -2.0f;
        return {d[0], d[1], d[2]};
    }
    const Triangle& triangle() {
        for (;;) {
            const std::uint32_t i = random_.below(static_cast<std::uint32_t>(mesh_.triangles.size()));
            if (!is_inactive(mesh_, i)) return mesh_.triangles[i];
        }
    }
    Vec3 vertex() { return mesh_.vertices[triangle()[random_.below(3)]]; }
    Vec3 pick_coordinates(const Vec3& a, const Vec3& b) {
        return {random_.below(2) == 0 ? a.x : b.x, random_.below(2) == 0 ? a.y : b.y,
                random_.below(2) == 0 ? a.z : b.z};
    }
    Vec3 on_edge() {
        const Triangle& t = triangle();
        const std::uint32_t first = random_.below(3);
        return mix(mesh_.vertices[t[first]], mesh_.vertices[t[(first + 1) % 3]],
                   random_.below(3) == 0 ? 0.5f : random_.unit());
    }
    Vec3 on_triangle() {
        const Triangle& t = triangle();
        const Vec3 edge_point = mix(mesh_.vertices[t[0]], mesh_.vertices[t[1]], random_.unit());
        return mix(edge_point, mesh_.vertices[t[2]], random_.unit());
    }
    Ray along_edge(const Vec3& fallback) {
        const Triangle& t = triangle();
        const Vec3 a = mesh_.vertices[t[0]], b = mesh_.vertices[t[1]];
        const Vec3 direction = from_to(a, b);
        if (direction == Vec3{}) return towards(fallback, a);
        return {mix(a, b, -1.0f), 0.0f, direction, infinity()};
    }
    /// Parallel to two axes' plane, through a vertex.
    Ray in_plane() {
        Ray ray = towards(in_box(-0.5f, 1.5f), vertex());
        const std::uint32_t flat = random_.below(3);
        const Vec3 target = vertex();
        (flat == 0 ? ray.direction.x : flat == 1 ? ray.direction.y : ray.direction.z) = -0.0f;
        if (flat == 0) ray.origin.x = target.x;
        if (flat == 1) ray.origin.y = target.y;
        if (flat == 2) ray.origin.z = target.z;
        return ray;
    }

    const Mesh& mesh_;
    Random random_;
    Aabb box_;
};

Aabb box_of(const std::array<Point, 3>& vertices) {
    Aabb box;
    for (const Point& v : vertices)
        box = merge(box, Vec3{v[0], v[1], v[2]});
    return box;
}

}  // namespace

bool hits_nothing(const Ray& ray) {
    const Point direction = point(ray.direction);
    return !is_finite(point(ray.origin)) || !is_finite(direction) || direction == Point{} || std::isnan(ray.t_min) ||
           std::isnan(ray.t_max) || ray.t_min > ray.t_max;
}

std::optional<float> entry_of_box(const Aabb& box, const Ray& ray) {
    const Point o = point(ray.origin), d = point(ray.direction);
    const Point lower = point(box.lower), upper = point(box.upper);
    float entry = std::max(ray.t_min, 0.0f), exit = ray.t_max;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const float inverse = 1.0f / d[axis];
        const float to_lower = (lower[axis] - o[axis]) * inverse, to_upper = (upper[axis] - o[axis]) * inverse;
        const bool is_backwards = std::signbit(d[axis]);
        const float first = is_backwards ? to_upper : to_lower, last = is_backwards ? to_lower : to_upper;
        if (first > entry) entry = first;
        if (last < exit) exit = last;
    }
    if (entry <= exit * (1.0f + 1.0f / 262144)) return entry;
    return std::nullopt;
}

std::optional<Hit> hit_of_triangle(const Mesh& mesh, std::uint32_t triangle, const Ray& ray, TriangleTest test) {
    std::array<Point, 3> vertices{};
    for (std::size_t corner = 0; corner < 3; ++corner)
        vertices[corner] = point(mesh.vertices[mesh.triangles[triangle][corner]]);
    auto hit = test == TriangleTest::watertight ? watertight(vertices, ray) : moller_trumbore(vertices, ray);
    if (!hit || !(hit->t >= std::max(ray.t_min, 0.0f)) || !(hit->t <= ray.t_max)) return std::nullopt;
    const std::optional<float> entry = entry_of_box(box_of(vertices), ray);
    if (!entry) return std::nullopt;
    if (*entry > hit->t * (1.0f + 1.0f / 262144)) hit->t = *entry;
    if (!(hit->t <= ray.t_max)) return std::nullopt;
    hit->primitive = triangle;
    return hit;
}

std::vector<Hit> brute_force_all(const Mesh& mesh, const Ray& ray, TriangleTest test) {
    std::vector<Hit> hits;
    if (hits_nothing(ray)) return hits;
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        if (const std::optional<Hit> hit = hit_of_triangle(mesh, i, ray, test)) hits.push_back(*hit);
    }
    std::ranges::stable_sort(hits, {}, &Hit::t);
    return hits;
}

Hit brute_force_closest(const Mesh& mesh, const Ray& ray, TriangleTest test) {
    const std::vector<Hit> hits = brute_force_all(mesh, ray, test);
    return hits.empty() ? Hit{} : hits.front();
}

bool same_bits(const Hit& a, const Hit& b) {
    using Bytes = std::array<std::uint32_t, 4>;
    return std::bit_cast<Bytes>(a) == std::bit_cast<Bytes>(b);
}

std::vector<Ray> difficult_rays(const Mesh& mesh, std::size_t count, std::uint64_t seed) {
    RayMaker maker(mesh, seed);
    std::vector<Ray> rays;
    for (std::size_t i = 0; i < count * RayMaker::kKinds; ++i)
        rays.push_back(maker.make(i % RayMaker::kKinds));
    return rays;
}

std::vector<Ray> untraceable_rays() {
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    constexpr float infinity = std::numeric_limits<float>::infinity();
    std::vector<Ray> rays;
    for (const float bad : {nan, infinity, -infinity}) {
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 vector{0.25f, 0.5f, 0.125f};
            (axis == 0 ? vector.x : axis == 1 ? vector.y : vector.z) = bad;
            rays.push_back({vector, 0.0f, {1.0f, 0.5f, 0.25f}, infinity});
            rays.push_back({{0.25f, 0.5f, 0.125f}, 0.0f, vector, infinity});
        }
    }
    rays.push_back({{0, 0, 0}, 0.0f, {0.0f, -0.0f, 0.0f}, infinity});
    rays.push_back({{0, 0, 0}, nan, {1, 0, 0}, infinity});
    rays.push_back({{0, 0, 0}, 0.0f, {1, 0, 0}, nan});
    rays.push_back({{0, 0, 0}, 1.0f, {1, 0, 0}, 0.5f});
    rays.push_back({{0, 0, 0}, 0.0f, {1, 0, 0}, -1.0f});
    rays.push_back({{0, 0, 0}, infinity, {1, 0, 0}, 1.0f});
    return rays;
}

}  // namespace clbvh::test
