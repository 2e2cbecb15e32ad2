#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

namespace clbvh {

/// A point in double precision.
using Point = std::array<double, 3>;

/// A plane across an axis.
struct AxisPlane {
    std::size_t axis;
    double position;
};

/// Where an edge meets a plane that its ends are on both sides of, within the box of these.
[[nodiscard]] inline Point cross(const Point& a, const Point& b, const AxisPlane& plane) noexcept {
    const double t = (plane.position - a[plane.axis]) / (b[plane.axis] - a[plane.axis]);
    Point point;
    // Clamped: a coordinate that rounding takes beyond both ends would make a part larger than the whole, and planes
    // that were done with would cut again, without end.
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto [least, most] = std::minmax(a[axis], b[axis]);
        point[axis] = std::clamp(a[axis] + t * (b[axis] - a[axis]), least, most);
    }
    point[plane.axis] = plane.position;
    return point;
}

/// Cuts a convex polygon (Sutherland, Hodgman 1974). Calls `below(point)` and `above(point)` for the points of the
/// parts in turn; both have the cut, so that nothing is lost between them.
template <typename Below, typename Above>
void cut_polygon(std::span<const Point> polygon, const AxisPlane& plane, const Below& below, const Above& above) {
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Point& point = polygon[i];
        const Point& next = polygon[i + 1 < polygon.size() ? i + 1 : 0];
        const double from = point[plane.axis];
        const double to = next[plane.axis];
        if (from <= plane.position) below(point);
        if (from >= plane.position) above(point);
        if ((from < plane.position && plane.position < to) || (to < plane.position && plane.position < from)) {
            const Point crossing = cross(point, next, plane);
            below(crossing);
            above(crossing);
        }
    }
}

}  // namespace clbvh
