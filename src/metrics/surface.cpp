#include "metrics/surface.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

namespace clbvh {
namespace {

using Point = Surface::Point;

Point to_point(const Vec3& v) noexcept {
    return {v.x, v.y, v.z};
}

Point difference(const Point& a, const Point& b) noexcept {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// Of a flat polygon with its points in turn.
double area_of(std::span<const Point> polygon) noexcept {
    Point sum{};
    for (std::size_t i = 2; i < polygon.size(); ++i) {
        const Point a = difference(polygon[i - 1], polygon[0]);
        const Point b = difference(polygon[i], polygon[0]);
        sum[0] += a[1] * b[2] - a[2] * b[1];
        sum[1] += a[2] * b[0] - a[0] * b[2];
        sum[2] += a[0] * b[1] - a[1] * b[0];
    }
    return 0.5 * std::sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
}

/// A convex polygon that is clipped by planes across the axes (Sutherland, Hodgman 1974).
class Polygon {
public:
    explicit Polygon(const std::array<Point, 3>& corners) noexcept {
        std::copy(corners.begin(), corners.end(), points_->begin());
    }

    /// Keeps what is on the upper (sign 1) or the lower (sign -1) side of the plane, the plane itself included.
    void keep(std::size_t axis, double plane, double sign) noexcept {
        const std::span<const Point> before = points();
        current_ = 1 - current_;
        count_ = 0;
        Points& kept = points_[current_];
        for (std::size_t i = 0; i < before.size(); ++i) {
            const Point& from = before[i];
            const Point& to = before[i + 1 < before.size() ? i + 1 : 0];
            const double from_side = sign * (from[axis] - plane);
            const double to_side = sign * (to[axis] - plane);
            if (from_side >= 0.0) kept[count_++] = from;
            if ((from_side > 0.0 && to_side < 0.0) || (from_side < 0.0 && to_side > 0.0)) {
                Point& crossing = kept[count_++];
                const double t = from_side / (from_side - to_side);
                for (std::size_t k = 0; k < 3; ++k)
                    crossing[k] = from[k] + t * (to[k] - from[k]);
                crossing[axis] = plane;
            }
        }
    }

    [[nodiscard]] std::span<const Point> points() const noexcept { return std::span(points_[current_]).first(count_); }

private:
    /// A plane adds one point at most to what is convex. Rounding may leave it convex only nearly; then it adds no more
    /// than half of those there are, which is 3, 4, 6, 9, 13, 19, 28 with six planes.
    static constexpr std::size_t kMostPoints = 28;
    using Points = std::array<Point, kMostPoints>;

    Points points_[2];  // not initialised: only what was written is read
    std::size_t current_ = 0;
    std::size_t count_ = 3;
};

}  // namespace

Surface::Surface(const Mesh& mesh, std::uint32_t triangle) noexcept : bounds_(triangle_bounds(mesh, triangle)) {
    for (std::size_t i = 0; i < 3; ++i)
        corners_[i] = to_point(mesh.vertices[mesh.triangles[triangle][i]]);
    area_ = area_of(corners_);
}

double Surface::area_within(const Aabb& box) const noexcept {
    if (!touch(bounds_, box)) return 0.0;
    if (is_within(bounds_, box)) return area_;
    const Point lower = to_point(box.lower);
    const Point upper = to_point(box.upper);
    const Point own_lower = to_point(bounds_.lower);
    const Point own_upper = to_point(bounds_.upper);
    Polygon polygon(corners_);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (own_lower[axis] < lower[axis]) polygon.keep(axis, lower[axis], 1.0);
        if (own_upper[axis] > upper[axis]) polygon.keep(axis, upper[axis], -1.0);
    }
    return area_of(polygon.points());
}

Point Surface::at(double u, double v) const noexcept {
    Point point = corners_[0];
    for (std::size_t k = 0; k < 3; ++k)
        point[k] += u * (corners_[1][k] - corners_[0][k]) + v * (corners_[2][k] - corners_[0][k]);
    return point;
}

}  // namespace clbvh
