#include "metrics/triangle_surface.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "core/box_overlap.hpp"

namespace clbvh {
namespace {

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

/// A convex polygon that is clipped by planes across the axes.
class ClippedPolygon {
public:
    explicit ClippedPolygon(const std::array<Point, 3>& corners) noexcept {
        std::copy(corners.begin(), corners.end(), points_->begin());
    }

    /// Keeps what is on the side of the plane, the plane itself included.
    void keep_above(const AxisPlane& plane) noexcept {
        keep([&](std::span<const Point> before, const auto& add) {
            cut_polygon(
                before, plane, [](const Point&) {}, add);
        });
    }
    void keep_below(const AxisPlane& plane) noexcept {
        keep([&](std::span<const Point> before, const auto& add) {
            cut_polygon(before, plane, add, [](const Point&) {});
        });
    }

    [[nodiscard]] std::span<const Point> points() const noexcept { return std::span(points_[current_]).first(count_); }

private:
    template <typename Cut>
    void keep(const Cut& cut) noexcept {
        const std::span<const Point> before = points();
        current_ = 1 - current_;
        count_ = 0;
        cut(before, [&](const Point& point) { points_[current_][count_++] = point; });
    }

    /// A plane adds one point at most to what is convex. Rounding may leave it convex only nearly; then it adds no more
    /// than half of those there are, which is 3, 4, 6, 9, 13, 19, 28 with six planes.
    static constexpr std::size_t kMostPoints = 28;
    using Points = std::array<Point, kMostPoints>;

    Points points_[2];  // not initialised: only what was written is read
    std::size_t current_ = 0;
    std::size_t count_ = 3;
};

}  // namespace

TriangleSurface::TriangleSurface(const MeshView& mesh, std::uint32_t triangle) noexcept
    : bounds_(triangle_bounds(mesh, triangle)) {
    const Triangle indices = mesh.triangle(triangle);
    for (std::size_t i = 0; i < 3; ++i)
        corners_[i] = to_point(mesh.vertex(indices[i]));
    area_ = area_of(corners_);
}

double TriangleSurface::area_within(const Aabb& box) const noexcept {
    if (!touch(bounds_, box)) return 0.0;
    if (is_within(bounds_, box)) return area_;
    const Point lower = to_point(box.lower);
    const Point upper = to_point(box.upper);
    const Point own_lower = to_point(bounds_.lower);
    const Point own_upper = to_point(bounds_.upper);
    ClippedPolygon polygon(corners_);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (own_lower[axis] < lower[axis]) polygon.keep_above({axis, lower[axis]});
        if (own_upper[axis] > upper[axis]) polygon.keep_below({axis, upper[axis]});
    }
    return area_of(polygon.points());
}

Point TriangleSurface::at(double u, double v) const noexcept {
    Point point = corners_[0];
    for (std::size_t k = 0; k < 3; ++k)
        point[k] += u * (corners_[1][k] - corners_[0][k]) + v * (corners_[2][k] - corners_[0][k]);
    return point;
}

}  // namespace clbvh
