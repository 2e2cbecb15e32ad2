// Ear clipping of polygons (Meisters 1975, "Polygons have ears"). Three things keep it near-linear for polygons as they
// are modelled: cutting an ear changes whether its two neighbours are ears, and nothing else, so that each corner is
// tested about three times; corners that can block an ear, those that do not turn left, lie in a grid; and the corner
// behind an ear waits, so that no triangle fans out over all that is left.
#include "io/read/polygon.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace clbvh::io {
namespace {

struct Point {
    double x;
    double y;
};

/// Twice the signed area of a triangle, positive where it turns left.
double turn(const Point& a, const Point& b, const Point& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Corners seen in the coordinate plane that their polygon faces most, from its first corner, turned so that it runs to
/// the left. Differences of floats are exact in double unless they differ a billionfold, so that a polygon far from the
/// origin is what it is near to it.
class PolygonPlane {
public:
    PolygonPlane(std::span<const std::uint32_t> corners, const Mesh& mesh) : corners_(corners), mesh_(mesh) {
        const Vec3& first = mesh.vertices[corners[0]];
        origin_[0] = first.x;
        origin_[1] = first.y;
        origin_[2] = first.z;
        const double* const normal = measure_normal();
        const double x = std::abs(normal[0]);
        const double y = std::abs(normal[1]);
        const double z = std::abs(normal[2]);
        const int axis = x > y && x > z ? 0 : y > z ? 1 : 2;
        u_ = (axis + 1) % 3;
        v_ = (axis + 2) % 3;
        if (normal[axis] < 0) std::swap(u_, v_);
    }

    [[nodiscard]] std::size_t size() const { return corners_.size(); }
    [[nodiscard]] std::uint32_t corner(std::size_t i) const { return corners_[i]; }
    [[nodiscard]] Point point(std::size_t i) const { return {coordinate(i, u_), coordinate(i, v_)}; }

    [[nodiscard]] bool is_finite() const {
        return std::ranges::all_of(corners_, [&](std::uint32_t corner) {
            const Vec3& v = mesh_.vertices[corner];
            return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
        });
    }

    /// Whether a fan around the first corner covers the polygon once: it never turns right, and, unlike a star that
    /// goes around twice, no part of the fan does.
    [[nodiscard]] bool is_convex() const {
        const std::size_t n = size();
        const Point first = point(0);
        Point a = point(n - 2);
        Point b = point(n - 1);
        for (std::size_t i = 0; i < n; ++i) {
            const Point c = point(i);
            if (turn(a, b, c) < 0 || turn(first, b, c) < 0) return false;
            a = b;
            b = c;
        }
        return true;
    }

private:
    [[nodiscard]] double coordinate(std::size_t i, int axis) const {
        const Vec3& v = mesh_.vertices[corners_[i]];
        return double{axis == 0 ? v.x : axis == 1 ? v.y : v.z} - origin_[axis];
    }

    /// The polygon's area vector (Newell's method), doubled.
    const double* measure_normal() {
        for (std::size_t i = 0; i < size(); ++i) {
            const std::size_t j = i + 1 == size() ? 0 : i + 1;
            for (int axis = 0; axis < 3; ++axis) {
                const int u = (axis + 1) % 3;
                const int v = (axis + 2) % 3;
                normal_[axis] += (coordinate(i, u) - coordinate(j, u)) * (coordinate(i, v) + coordinate(j, v));
            }
        }
        return normal_;
    }

    std::span<const std::uint32_t> corners_;
    const Mesh& mesh_;
    double origin_[3];
    double normal_[3] = {};
    int u_;
    int v_;
};

constexpr std::uint32_t kNone = 0xffffffff;

/// Corners that turn right, by the cells of a grid over their plane: only they can lie in an ear.
class CornerGrid {
public:
    CornerGrid(const PolygonPlane& plane, std::vector<std::uint32_t> corners) : next_(plane.size(), kNone) {
        low_ = high_ = plane.point(0);
        for (std::size_t i = 1; i < plane.size(); ++i) {
            const Point p = plane.point(i);
            low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y)};
            high_ = {std::max(high_.x, p.x), std::max(high_.y, p.y)};
        }
        const double width = high_.x - low_.x;
        const double height = high_.y - low_.y;
        const auto count = static_cast<double>(std::max<std::size_t>(1, corners.size()));
        columns_ =
            static_cast<std::size_t>(std::clamp(std::sqrt(count * width / std::max(height, 1e-300)), 1.0, count));
        rows_ = std::max<std::size_t>(1, static_cast<std::size_t>(count) / columns_);
        heads_.assign(columns_ * rows_, kNone);
        for (const std::uint32_t corner : corners) {
            const Point p = plane.point(corner);
            std::uint32_t& head = heads_[row(p.y) * columns_ + column(p.x)];
            next_[corner] = head;
            head = corner;
        }
    }

    /// Calls `visit(corner)` for corners in and around a box until one is true. Returns whether one was, and adds the
    /// steps that it took.
    template <typename Visit>
    bool any_in(const Point& low, const Point& high, std::uint64_t& steps, const Visit& visit) const {
        const std::size_t last_row = row(high.y);
        const std::size_t last_column = column(high.x);
        for (std::size_t r = row(low.y); r <= last_row; ++r) {
            for (std::size_t c = column(low.x); c <= last_column; ++c) {
                ++steps;
                for (std::uint32_t corner = heads_[r * columns_ + c]; corner != kNone; corner = next_[corner]) {
                    ++steps;
                    if (visit(corner)) return true;
                }
            }
        }
        return false;
    }

private:
    [[nodiscard]] std::size_t column(double x) const { return cell(x, low_.x, high_.x, columns_); }
    [[nodiscard]] std::size_t row(double y) const { return cell(y, low_.y, high_.y, rows_); }

    static std::size_t cell(double at, double low, double high, std::size_t cells) {
        if (!(high > low)) return 0;
        const double part = std::clamp((at - low) / (high - low), 0.0, 1.0);
        return std::min(cells - 1, static_cast<std::size_t>(part * static_cast<double>(cells)));
    }

    Point low_{};
    Point high_{};
    std::size_t columns_ = 1;
    std::size_t rows_ = 1;
    std::vector<std::uint32_t> heads_;
    std::vector<std::uint32_t> next_;
};

/// Cuts ears off a polygon until a triangle, or no ear, is left.
class EarClipper {
public:
    EarClipper(const PolygonPlane& plane, Mesh& mesh, const std::function<void()>& tick)
        : plane_(plane),
          mesh_(mesh),
          tick_(tick),
          left_(static_cast<std::uint32_t>(plane.size())),
          before_(left_),
          after_(left_),
          queue_(left_),
          is_queued_(left_),
          is_deferred_(left_),
          grid_(plane, link()) {}

    /// Returns whether the whole polygon was cut into ears.
    bool clip() {
        // Ears first, so that no corner between two others in one line makes a triangle without area where it need not;
        // then such corners, then ears that the polygon touches from outside.
        for (int leniency = 0; leniency <= 2 && left_ > 3; ++leniency) {
            for (std::uint32_t i = first_, n = left_; n > 0; --n, i = after_[i])
                enqueue(i);
            while (queued_ > 0 && left_ > 3 && steps_ < kMaxStepsPerCorner * plane_.size() + kFreeSteps)
                test(dequeue(), leniency);
        }
        const bool done =
            left_ == 3 && turn(plane_.point(before_[first_]), plane_.point(first_), plane_.point(after_[first_])) >= 0;
        append_rest();
        return done;
    }

private:
    static constexpr std::uint64_t kMaxStepsPerCorner = 2000, kFreeSteps = 100000;
    static constexpr std::uint64_t kStepsBetweenTicks = 100000;

    /// Links all corners, and returns those that turn right or not at all.
    std::vector<std::uint32_t> link() {
        std::vector<std::uint32_t> turning_right;
        for (std::uint32_t i = 0; i < left_; ++i) {
            before_[i] = i == 0 ? left_ - 1 : i - 1;
            after_[i] = i + 1 == left_ ? 0 : i + 1;
        }
        for (std::uint32_t i = 0; i < left_; ++i) {
            if (!(turn(plane_.point(before_[i]), plane_.point(i), plane_.point(after_[i])) > 0))
                turning_right.push_back(i);
        }
        return turning_right;
    }

    [[nodiscard]] bool is_cut(std::uint32_t i) const { return after_[i] == kNone; }

    void enqueue(std::uint32_t i) {
        if (is_queued_[i]) return;
        is_queued_[i] = true;
        std::size_t end = head_ + queued_++;
        if (end >= queue_.size()) end -= queue_.size();
        queue_[end] = i;
    }

    std::uint32_t dequeue() {
        const std::uint32_t i = queue_[head_];
        if (++head_ == queue_.size()) head_ = 0;
        --queued_;
        is_queued_[i] = false;
        return i;
    }

    void test(std::uint32_t tip, int leniency) {
        if (is_cut(tip)) return;
        // The corner behind an ear waits for the next round: else ears become ever longer, all around one corner.
        if (is_deferred_[tip]) {
            is_deferred_[tip] = false;
            return enqueue(tip);
        }
        if (is_ear(tip, leniency)) cut(tip);
        if (++steps_ < next_tick_) return;
        tick_();
        next_tick_ = steps_ + kStepsBetweenTicks;
    }

    bool is_ear(std::uint32_t tip, int leniency) {
        const std::uint32_t from = before_[tip];
        const std::uint32_t to = after_[tip];
        const Point corners[3] = {plane_.point(from), plane_.point(tip), plane_.point(to)};
        const double area = turn(corners[0], corners[1], corners[2]);
        if (area == 0) return leniency > 0;
        if (!(area > 0)) return false;
        const auto [left, right] = std::minmax({corners[0].x, corners[1].x, corners[2].x});
        const auto [low, high] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
        return !grid_.any_in({left, low}, {right, high}, steps_, [&](std::uint32_t i) {
            return i != from && i != tip && i != to && !is_cut(i) && blocks(i, corners, leniency);
        });
    }

    /// Whether corner `i` keeps a triangle from being an ear: it lies within, or on the border with an edge that goes
    /// inside. On the border alone are corners where a polygon with a hole is cut open.
    [[nodiscard]] bool blocks(std::uint32_t i, const Point (&corners)[3], int leniency) const {
        const Point p = plane_.point(i);
        bool on_side[3];
        for (int side = 0; side < 3; ++side) {
            const double area = turn(corners[side], corners[(side + 1) % 3], p);
            if (area < 0) return false;
            on_side[side] = area == 0;
        }
        const bool only_on_cut = on_side[2] && !on_side[0] && !on_side[1];
        if (only_on_cut && leniency < 2) return true;
        const auto goes_inside = [&](const Point& q) {
            for (int side = 0; side < 3; ++side) {
                if (on_side[side] && !(turn(corners[side], corners[(side + 1) % 3], q) > 0)) return false;
            }
            return true;
        };
        return goes_inside(plane_.point(before_[i])) || goes_inside(plane_.point(after_[i]));
    }

    void cut(std::uint32_t tip) {
        const std::uint32_t from = before_[tip];
        const std::uint32_t to = after_[tip];
        append(from, tip, to);
        after_[from] = to;
        before_[to] = from;
        after_[tip] = kNone;
        if (first_ == tip) first_ = to;
        --left_;
        is_deferred_[to] = is_queued_[to];
        enqueue(from);
        enqueue(to);
    }

    void append_rest() {
        std::uint32_t middle = after_[first_];
        for (; after_[middle] != first_; middle = after_[middle])
            append(first_, middle, after_[middle]);
    }

    void append(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        mesh_.triangles.push_back({plane_.corner(a), plane_.corner(b), plane_.corner(c)});
    }

    const PolygonPlane& plane_;
    Mesh& mesh_;
    const std::function<void()>& tick_;
    std::uint32_t left_;
    std::uint32_t first_ = 0;
    std::vector<std::uint32_t> before_;
    std::vector<std::uint32_t> after_;  // kNone where a corner was cut off
    std::vector<std::uint32_t> queue_;
    std::size_t head_ = 0;
    std::size_t queued_ = 0;
    std::vector<bool> is_queued_;
    std::vector<bool> is_deferred_;
    std::uint64_t steps_ = 0;
    std::uint64_t next_tick_ = kStepsBetweenTicks;
    CornerGrid grid_;
};

void append_fan(std::span<const std::uint32_t> corners, Mesh& mesh) {
    for (std::size_t i = 2; i < corners.size(); ++i) {
        mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
    }
}

/// So that filling many polygons takes linear time, and one no more room than it needs.
void reserve_triangles(Mesh& mesh, std::size_t more) {
    const std::size_t needed = mesh.triangles.size() + more;
    if (needed <= mesh.triangles.capacity()) return;
    mesh.triangles.reserve(std::max(needed, mesh.triangles.capacity() + mesh.triangles.capacity() / 2));
}

}  // namespace

PolygonCut append_polygon(std::span<const std::uint32_t> corners, Mesh& mesh, const std::function<void()>& tick) {
    reserve_triangles(mesh, corners.size() - 2);
    if (corners.size() > 3) {
        const PolygonPlane plane(corners, mesh);
        if (!plane.is_finite()) {
            append_fan(corners, mesh);
            return PolygonCut::fan;
        }
        if (!plane.is_convex()) return EarClipper(plane, mesh, tick).clip() ? PolygonCut::clean : PolygonCut::fan;
    }
    append_fan(corners, mesh);
    return PolygonCut::clean;
}

}  // namespace clbvh::io
