#include "io/polygon.hpp"

#include <cmath>
#include <cstddef>
#include <vector>

namespace clbvh::io {
namespace {

struct Point {
    double x;
    double y;

    friend bool operator==(const Point&, const Point&) = default;
};

/// Twice the signed area of a triangle, positive where it turns left.
double turn(const Point& a, const Point& b, const Point& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

bool contains(const Point& a, const Point& b, const Point& c, const Point& p) {
    return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
}

void append_fan(std::span<const std::uint32_t> corners, Mesh& mesh) {
    for (std::size_t i = 2; i < corners.size(); ++i) {
        mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
    }
}

/// The polygon's area vector (Newell's method), doubled.
struct Normal {
    double x = 0.0;
    double y = 0.0;
    double z = 0.0;
};

Normal newell_normal(std::span<const std::uint32_t> corners, const Mesh& mesh) {
    Normal normal;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec3& a = mesh.vertices[corners[i]];
        const Vec3& b = mesh.vertices[corners[(i + 1) % corners.size()]];
        normal.x += (double{a.y} - b.y) * (double{a.z} + b.z);
        normal.y += (double{a.z} - b.z) * (double{a.x} + b.x);
        normal.z += (double{a.x} - b.x) * (double{a.y} + b.y);
    }
    return normal;
}

/// The corners in the coordinate plane that the polygon faces most, turned so that the polygon runs to the left.
std::vector<Point> project(std::span<const std::uint32_t> corners, const Mesh& mesh) {
    const Normal normal = newell_normal(corners, mesh);
    const double x = std::abs(normal.x);
    const double y = std::abs(normal.y);
    const double z = std::abs(normal.z);
    const bool along_x = x > y && x > z;
    const bool along_y = !along_x && y > z;
    const double facing = along_x ? normal.x : along_y ? normal.y : normal.z;

    std::vector<Point> points;
    points.reserve(corners.size());
    for (const std::uint32_t corner : corners) {
        const Vec3& v = mesh.vertices[corner];
        const Point point = along_x ? Point{v.y, v.z} : along_y ? Point{v.z, v.x} : Point{v.x, v.y};
        points.push_back(facing < 0 ? Point{point.y, point.x} : point);
    }
    return points;
}

bool is_concave(const std::vector<Point>& points) {
    const std::size_t n = points.size();
    for (std::size_t i = 0; i < n; ++i) {
        if (turn(points[i], points[(i + 1) % n], points[(i + 2) % n]) < 0) return true;
    }
    return false;
}

/// Cuts ears off a polygon until a triangle, or no ear, is left.
class EarClipper {
public:
    EarClipper(std::span<const std::uint32_t> corners, std::vector<Point> points, Mesh& mesh)
        : corners_(corners.begin(), corners.end()), points_(std::move(points)), mesh_(mesh) {}

    void clip() {
        std::size_t tip = 1;
        std::size_t misses = 0;
        while (corners_.size() > 3 && misses < corners_.size()) {
            tip %= corners_.size();
            if (is_ear(tip)) {
                cut(tip);
                misses = 0;
            } else {
                ++tip;
                ++misses;
            }
        }
        append_fan(corners_, mesh_);
    }

private:
    [[nodiscard]] std::size_t before(std::size_t i) const { return (i + corners_.size() - 1) % corners_.size(); }
    [[nodiscard]] std::size_t after(std::size_t i) const { return (i + 1) % corners_.size(); }

    [[nodiscard]] bool is_ear(std::size_t tip) const {
        const Point& a = points_[before(tip)];
        const Point& b = points_[tip];
        const Point& c = points_[after(tip)];
        if (!(turn(a, b, c) > 0)) return false;
        for (const Point& p : points_) {
            // Corners at the same place are where a polygon with a hole is cut open; they do not block.
            if (p != a && p != b && p != c && contains(a, b, c, p)) return false;
        }
        return true;
    }

    void cut(std::size_t tip) {
        mesh_.triangles.push_back({corners_[before(tip)], corners_[tip], corners_[after(tip)]});
        corners_.erase(corners_.begin() + static_cast<std::ptrdiff_t>(tip));
        points_.erase(points_.begin() + static_cast<std::ptrdiff_t>(tip));
    }

    std::vector<std::uint32_t> corners_;
    std::vector<Point> points_;
    Mesh& mesh_;
};

}  // namespace

void append_polygon(std::span<const std::uint32_t> corners, Mesh& mesh) {
    if (corners.size() == 3 || corners.size() > kMaxClippedCorners) return append_fan(corners, mesh);
    std::vector<Point> points = project(corners, mesh);
    if (!is_concave(points)) return append_fan(corners, mesh);
    EarClipper(corners, std::move(points), mesh).clip();
}

}  // namespace clbvh::io
