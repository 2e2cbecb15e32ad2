#include "support/oracle/epo_oracle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <vector>

namespace clbvh::test {
namespace {

using Coordinates = std::array<double, 3>;

Coordinates coordinates_of(const Vec3& v) {
    return {v.x, v.y, v.z};
}

/// Of the plane of a triangle whose corners are (0, 0), (1, 0) and (0, 1).
struct PlanePoint {
    double u;
    double v;
};

/// a u + b v <= c, up to rounding.
struct HalfPlane {
    double a;
    double b;
    double c;

    [[nodiscard]] bool holds(const PlanePoint& p) const {
        return a * p.u + b * p.v <= c + 1e-11 * (std::abs(a) + std::abs(b) + std::abs(c));
    }
};

std::vector<HalfPlane> half_planes_of(const std::array<Coordinates, 3>& corners, const Aabb& box) {
    const Coordinates lower = coordinates_of(box.lower);
    const Coordinates upper = coordinates_of(box.upper);
    std::vector<HalfPlane> list{{-1, 0, 0}, {0, -1, 0}, {1, 1, 1}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double a = corners[1][axis] - corners[0][axis];
        const double b = corners[2][axis] - corners[0][axis];
        list.push_back({a, b, upper[axis] - corners[0][axis]});
        list.push_back({-a, -b, corners[0][axis] - lower[axis]});
    }
    return list;
}

std::vector<PlanePoint> corners_of(const std::vector<HalfPlane>& half_planes) {
    std::vector<PlanePoint> points;
    for (std::size_t i = 0; i < half_planes.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            const auto& [a, b, c] = half_planes[i];
            const auto& [d, e, f] = half_planes[j];
            const double determinant = a * e - b * d;
            if (determinant == 0.0) continue;
            const PlanePoint point{(c * e - b * f) / determinant, (a * f - c * d) / determinant};
            if (std::ranges::all_of(half_planes, [&](const HalfPlane& h) { return h.holds(point); }))
                points.push_back(point);
        }
    }
    return points;
}

/// Of the convex polygon around the points, whatever their order.
double area_of(std::vector<PlanePoint> points) {
    if (points.size() < 3) return 0.0;
    PlanePoint centre{0, 0};
    for (const PlanePoint& point : points) {
        centre.u += point.u / static_cast<double>(points.size());
        centre.v += point.v / static_cast<double>(points.size());
    }
    std::ranges::sort(points, {}, [&](const PlanePoint& p) { return std::atan2(p.v - centre.v, p.u - centre.u); });
    double sum = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const PlanePoint& p = points[i];
        const PlanePoint& q = points[(i + 1) % points.size()];
        sum += (p.u - centre.u) * (q.v - centre.v) - (q.u - centre.u) * (p.v - centre.v);
    }
    return 0.5 * std::abs(sum);
}

std::array<Coordinates, 3> corners_of(const Mesh& mesh, std::size_t triangle) {
    const auto& [a, b, c] = mesh.triangles[triangle];
    return {coordinates_of(mesh.vertices[a]), coordinates_of(mesh.vertices[b]), coordinates_of(mesh.vertices[c])};
}

/// Heron's formula, as Kahan writes it.
double area_of(const std::array<Coordinates, 3>& corners) {
    const auto length = [&](std::size_t i, std::size_t j) {
        return std::hypot(corners[i][0] - corners[j][0], corners[i][1] - corners[j][1], corners[i][2] - corners[j][2]);
    };
    std::array<double, 3> sides{length(0, 1), length(1, 2), length(2, 0)};
    std::ranges::sort(sides, std::greater<>());
    const auto [a, b, c] = sides;
    return 0.25 * std::sqrt(std::max(0.0, (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))));
}

std::set<std::uint32_t> triangles_below(const Bvh& bvh, std::uint32_t index) {
    const Node& node = bvh.nodes[index];
    if (node.is_leaf()) {
        const auto begin = bvh.primitive_ids.begin() + node.first;
        return {begin, begin + node.count};
    }
    std::set<std::uint32_t> all = triangles_below(bvh, node.first);
    all.merge(triangles_below(bvh, node.first + 1));
    return all;
}

double sum_below(const Bvh& bvh, const Mesh& mesh, const SahCosts& costs, std::uint32_t index) {
    const Node& node = bvh.nodes[index];
    const std::set<std::uint32_t> own = triangles_below(bvh, index);
    double area = 0.0;
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        if (!own.contains(i) && !is_inactive(mesh, i)) area += area_within_oracle(mesh, i, node.bounds());
    }
    if (node.is_leaf()) return costs.primitive * node.count * area;
    return costs.inner * area + sum_below(bvh, mesh, costs, node.first) + sum_below(bvh, mesh, costs, node.first + 1);
}

}  // namespace

double area_within_oracle(const Mesh& mesh, std::size_t triangle, const Aabb& box) {
    const Aabb bounds = triangle_bounds(mesh, triangle);
    const Aabb both = merge(box, bounds);
    if (both == box) return area_of(corners_of(mesh, triangle));
    const std::array<Coordinates, 3> corners = corners_of(mesh, triangle);
    return 2.0 * area_of(corners) * area_of(corners_of(half_planes_of(corners, box)));
}

double epo_oracle(const Bvh& bvh, const Mesh& mesh, const SahCosts& costs) {
    double area = 0.0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        if (!is_inactive(mesh, i)) area += area_of(corners_of(mesh, i));
    }
    return bvh.empty() || area == 0.0 ? 0.0 : sum_below(bvh, mesh, costs, 0) / area;
}

}  // namespace clbvh::test
