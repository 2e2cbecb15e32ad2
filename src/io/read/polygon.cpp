// Ear clipping of polygons (Meisters 1975, "Polygons have ears"). Two things keep it near-linear for polygons as they
// are modelled: corners that can block an ear, those that are not convex, lie in a grid; and clipping goes on behind
// the next corner, so that every other corner goes in each round and no triangle fans out over all that is left.
#include "io/read/polygon.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
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

/// A corner relative to the first one: far from the origin nothing else is left of its digits.
struct Corner {
    double x, y, z;
};

std::vector<Corner> relative(std::span<const std::uint32_t> corners, const Mesh& mesh) {
    const Vec3& first = mesh.vertices[corners[0]];
    std::vector<Corner> result;
    result.reserve(corners.size());
    for (const std::uint32_t corner : corners) {
        const Vec3& v = mesh.vertices[corner];
        result.push_back({double{v.x} - first.x, double{v.y} - first.y, double{v.z} - first.z});
    }
    return result;
}

/// The polygon's area vector (Newell's method), doubled.
Corner newell_normal(const std::vector<Corner>& corners) {
    Corner normal{0.0, 0.0, 0.0};
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Corner& a = corners[i];
        const Corner& b = corners[(i + 1) % corners.size()];
        normal.x += (a.y - b.y) * (a.z + b.z);
        normal.y += (a.z - b.z) * (a.x + b.x);
        normal.z += (a.x - b.x) * (a.y + b.y);
    }
    return normal;
}

/// The corners in the coordinate plane that the polygon faces most, turned so that the polygon runs to the left.
std::vector<Point> project(const std::vector<Corner>& corners) {
    const Corner normal = newell_normal(corners);
    const double x = std::abs(normal.x);
    const double y = std::abs(normal.y);
    const double z = std::abs(normal.z);
    const bool along_x = x > y && x > z;
    const bool along_y = !along_x && y > z;
    const double facing = along_x ? normal.x : along_y ? normal.y : normal.z;

    std::vector<Point> points;
    points.reserve(corners.size());
    for (const Corner& v : corners) {
        const Point point = along_x ? Point{v.y, v.z} : along_y ? Point{v.z, v.x} : Point{v.x, v.y};
        points.push_back(facing < 0 ? Point{point.y, point.x} : point);
    }
    return points;
}

bool is_finite(const std::vector<Point>& points) {
    return std::ranges::all_of(points, [](const Point& p) { return std::isfinite(p.x) && std::isfinite(p.y); });
}

/// Whether no corner turns right, and the outline goes once from left to right and once back: a star of five points
/// turns left everywhere, too, but goes around twice.
bool is_convex(const std::vector<Point>& points) {
    const std::size_t n = points.size();
    int first_way = 0, way = 0, changes = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const Point &a = points[i], &b = points[(i + 1) % n];
        if (turn(a, b, points[(i + 2) % n]) < 0) return false;
        const int next_way = a.x < b.x ? 1 : a.x > b.x ? -1 : way;
        changes += way != 0 && next_way != way ? 1 : 0;
        if (first_way == 0) first_way = next_way;
        way = next_way;
    }
    changes += way != first_way ? 1 : 0;
    return changes <= 2;
}

/// How often the outline turns around as it is gone along: once where it does not intersect itself.
double turns_around(const std::vector<Point>& points) {
    const std::size_t n = points.size();
    double sum = 0.0;
    Point last{0.0, 0.0};
    const auto go = [&](const Point& step) {
        if (last != Point{0.0, 0.0})
            sum += std::atan2(last.x * step.y - last.y * step.x, last.x * step.x + last.y * step.y);
        last = step;
    };
    for (std::size_t i = 0; i <= n; ++i) {
        const Point &a = points[i % n], &b = points[(i + 1) % n];
        if (a != b) go({b.x - a.x, b.y - a.y});
    }
    return sum / (2.0 * std::numbers::pi);
}

/// A box around points.
struct Extent {
    Point lower, upper;

    void add(const Point& p) {
        lower = {std::min(lower.x, p.x), std::min(lower.y, p.y)};
        upper = {std::max(upper.x, p.x), std::max(upper.y, p.y)};
    }
};

/// Points in the cells of a square grid.
class PointGrid {
public:
    PointGrid(const std::vector<Point>& points, const std::vector<std::uint32_t>& members)
        : extent_{points[0], points[0]},
          side_(std::clamp<std::size_t>(static_cast<std::size_t>(std::sqrt(double(members.size()))), 1, 1024)) {
        for (const Point& p : points)
            extent_.add(p);
        begins_.assign(side_ * side_ + 1, 0);
        for (const std::uint32_t i : members)
            ++begins_[cell_of(points[i]) + 1];
        for (std::size_t cell = 0; cell < side_ * side_; ++cell)
            begins_[cell + 1] += begins_[cell];
        members_.resize(members.size());
        std::vector<std::uint32_t> ends(begins_.begin(), begins_.end() - 1);
        for (const std::uint32_t i : members)
            members_[ends[cell_of(points[i])]++] = i;
    }

    /// Calls visit(member) for those in the cells that the box touches until it returns false. False where it did.
    /// Adds what that took to `work`.
    template <typename Visit>
    bool visit(const Extent& box, std::size_t& work, const Visit& visit) const {
        const std::size_t x_end = index(box.upper.x, extent_.lower.x, extent_.upper.x);
        const std::size_t y_end = index(box.upper.y, extent_.lower.y, extent_.upper.y);
        for (std::size_t y = index(box.lower.y, extent_.lower.y, extent_.upper.y); y <= y_end; ++y) {
            for (std::size_t x = index(box.lower.x, extent_.lower.x, extent_.upper.x); x <= x_end; ++x) {
                const std::size_t cell = y * side_ + x;
                work += 1 + begins_[cell + 1] - begins_[cell];
                for (std::uint32_t i = begins_[cell]; i < begins_[cell + 1]; ++i) {
                    if (!visit(members_[i])) return false;
                }
            }
        }
        return true;
    }

private:
    [[nodiscard]] std::size_t index(double value, double lower, double upper) const {
        const double place = upper > lower ? (value - lower) / (upper - lower) * static_cast<double>(side_) : 0.0;
        return std::min(static_cast<std::size_t>(std::clamp(place, 0.0, 1024.0)), side_ - 1);
    }
    [[nodiscard]] std::size_t cell_of(const Point& p) const {
        return index(p.y, extent_.lower.y, extent_.upper.y) * side_ + index(p.x, extent_.lower.x, extent_.upper.x);
    }

    Extent extent_;
    std::size_t side_;
    std::vector<std::uint32_t> begins_, members_;
};

/// Cuts ears off a polygon until a triangle, or no ear, is left.
class EarClipper {
public:
    EarClipper(std::span<const std::uint32_t> corners, const std::vector<Point>& points, Mesh& mesh)
        : corners_(corners),
          points_(points),
          mesh_(mesh),
          next_(corners.size()),
          previous_(corners.size()),
          is_cut_(corners.size(), 0),
          is_changed_(corners.size(), 0),
          left_(corners.size()) {
        for (std::uint32_t i = 0; i < left_; ++i) {
            next_[i] = i + 1 < left_ ? i + 1 : 0;
            previous_[i] = i > 0 ? i - 1 : static_cast<std::uint32_t>(left_ - 1);
        }
    }

    /// In rounds. A corner whose neighbour was cut waits for the next round, in which only such corners are tried;
    /// where that brings nothing, all that are left are.
    PolygonCut clip(const std::function<void()>& tick) {
        const PointGrid blockers(points_, not_convex());
        std::vector<std::uint32_t> tried = rest(0);
        bool are_all = true;
        while (left_ > 3 && !is_exhausted()) {
            const std::size_t before = left_;
            changed_.clear();
            for (const std::uint32_t tip : tried) {
                if (left_ == 3 || is_exhausted()) break;
                count_work(tick);
                if (is_cut_[tip] == 0 && is_changed_[tip] == 0 && is_ear(tip, blockers)) cut(tip);
            }
            for (const std::uint32_t corner : changed_)
                is_changed_[corner] = 0;
            if (left_ == before && are_all && !cut_flat()) break;
            are_all = left_ == before || changed_.empty();
            tried = are_all ? rest(0) : changed_;
        }
        const bool is_clean = left_ == 3;
        append_fan(corners_of(rest(0)), mesh_);
        return is_clean ? PolygonCut::clean : PolygonCut::fan;
    }

private:
    static constexpr std::size_t kWorkPerCorner = 2000, kFreeWork = 100000;

    [[nodiscard]] bool is_exhausted() const { return work_ > kWorkPerCorner * corners_.size() + kFreeWork; }
    void count_work(const std::function<void()>& tick) {
        if (++work_ < next_tick_) return;
        tick();
        next_tick_ = work_ + kFreeWork;
    }

    [[nodiscard]] double turn_at(std::uint32_t i) const {
        return turn(points_[previous_[i]], points_[i], points_[next_[i]]);
    }
    [[nodiscard]] std::vector<std::uint32_t> not_convex() const {
        std::vector<std::uint32_t> result;
        for (std::uint32_t i = 0; i < corners_.size(); ++i) {
            if (turn_at(i) <= 0) result.push_back(i);
        }
        return result;
    }

    [[nodiscard]] bool is_ear(std::uint32_t tip, const PointGrid& blockers) {
        const Point& a = points_[previous_[tip]];
        const Point& b = points_[tip];
        const Point& c = points_[next_[tip]];
        if (!(turn(a, b, c) > 0)) return false;
        Extent box{a, a};
        box.add(b);
        box.add(c);
        return blockers.visit(box, work_, [&](std::uint32_t i) {
            const Point& p = points_[i];
            // Corners at the same place are where a polygon with a hole is cut open; they do not block.
            return is_cut_[i] != 0 || p == a || p == b || p == c || !contains(a, b, c, p);
        });
    }

    void cut(std::uint32_t tip) {
        mesh_.triangles.push_back({corners_[previous_[tip]], corners_[tip], corners_[next_[tip]]});
        next_[previous_[tip]] = next_[tip];
        previous_[next_[tip]] = previous_[tip];
        is_cut_[tip] = 1;
        --left_;
        for (const std::uint32_t neighbour : {previous_[tip], next_[tip]}) {
            if (is_changed_[neighbour] == 0) changed_.push_back(neighbour);
            is_changed_[neighbour] = 1;
        }
    }
    /// Cuts a corner off that does not turn, which only makes a triangle without area. False if there is none.
    bool cut_flat() {
        for (const std::uint32_t corner : rest(0)) {
            if (turn_at(corner) != 0) continue;
            cut(corner);
            for (const std::uint32_t each : changed_)
                is_changed_[each] = 0;
            return true;
        }
        return false;
    }

    /// The corners that are left, from the first one at or behind `first`.
    [[nodiscard]] std::vector<std::uint32_t> rest(std::uint32_t first) const {
        while (is_cut_[first] != 0)
            ++first;
        std::vector<std::uint32_t> result;
        result.reserve(left_);
        for (std::uint32_t i = first; result.size() < left_; i = next_[i])
            result.push_back(i);
        return result;
    }
    [[nodiscard]] std::vector<std::uint32_t> corners_of(std::vector<std::uint32_t> numbers) const {
        for (std::uint32_t& number : numbers)
            number = corners_[number];
        return numbers;
    }

    std::span<const std::uint32_t> corners_;
    const std::vector<Point>& points_;
    Mesh& mesh_;
    std::vector<std::uint32_t> next_, previous_;
    std::vector<std::uint8_t> is_cut_, is_changed_;
    std::vector<std::uint32_t> changed_;  // in this round, by a cut beside them
    std::size_t left_, work_ = 0, next_tick_ = kFreeWork;
};

}  // namespace

PolygonCut append_polygon(std::span<const std::uint32_t> corners, Mesh& mesh, const std::function<void()>& tick) {
    if (corners.size() == 3) {
        append_fan(corners, mesh);
        return PolygonCut::clean;
    }
    const std::vector<Point> points = project(relative(corners, mesh));
    const bool is_sound = is_finite(points);
    if (!is_sound || is_convex(points)) {
        append_fan(corners, mesh);
        return is_sound ? PolygonCut::clean : PolygonCut::fan;
    }
    const PolygonCut cut = EarClipper(corners, points, mesh).clip(tick);
    return std::round(turns_around(points)) == 1.0 ? cut : PolygonCut::fan;
}

}  // namespace clbvh::io
