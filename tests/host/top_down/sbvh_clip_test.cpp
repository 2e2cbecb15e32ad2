// Cut references: nothing of the triangle is lost, and the parts are hardly larger than they must be.
#include "host/top_down/sbvh_clip.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "clbvh/core/mesh.hpp"

using namespace clbvh;
using namespace clbvh::host;

namespace {

using Point = std::array<double, 3>;

Point to_point(const Vec3& v) {
    return {v.x, v.y, v.z};
}

/// The part of a convex polygon with sign * coordinate <= sign * position. Sutherland, Hodgman 1974.
std::vector<Point> clip(const std::vector<Point>& polygon, std::size_t axis, double position, double sign) {
    std::vector<Point> result;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Point& a = polygon[i];
        const Point& b = polygon[(i + 1) % polygon.size()];
        const bool a_inside = sign * a[axis] <= sign * position;
        const bool b_inside = sign * b[axis] <= sign * position;
        if (a_inside) result.push_back(a);
        if (a_inside == b_inside) continue;
        const double t = (position - a[axis]) / (b[axis] - a[axis]);
        Point crossing;
        for (std::size_t k = 0; k < 3; ++k)
            crossing[k] = a[k] + t * (b[k] - a[k]);
        crossing[axis] = position;
        result.push_back(crossing);
    }
    return result;
}

/// The part of the polygon that a box covers.
std::vector<Point> clip_to_box(std::vector<Point> polygon, const Aabb& box) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        polygon = clip(polygon, axis, to_point(box.lower)[axis], -1.0);
        polygon = clip(polygon, axis, to_point(box.upper)[axis], 1.0);
    }
    return polygon;
}

Aabb to_aabb(const Box4& box) {
    return {{box.lower.x(), box.lower.y(), box.lower.z()}, {box.upper.x(), box.upper.y(), box.upper.z()}};
}

/// How far the point is outside of the box.
double distance(const Point& point, const Aabb& box) {
    double result = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        result = std::max(result, to_point(box.lower)[axis] - point[axis]);
        result = std::max(result, point[axis] - to_point(box.upper)[axis]);
    }
    return result;
}

struct Case {
    Mesh mesh;
    Reference reference;
};

class CaseSource {
public:
    float between(float lower, float upper) { return std::uniform_real_distribution<float>(lower, upper)(random_); }

    /// A triangle around `centre`, and a reference to the part of it in a random box.
    Case next(float size, float centre) {
        const auto coordinate = [&] { return centre + between(-size, size); };
        Case c;
        for (int i = 0; i < 3; ++i)
            c.mesh.vertices.push_back({coordinate(), coordinate(), coordinate()});
        if (random_() % 4 == 0) c.mesh.vertices[1].y = c.mesh.vertices[0].y;
        if (random_() % 8 == 0) c.mesh.vertices[2] = c.mesh.vertices[1];
        c.mesh.triangles = {{0, 1, 2}};
        Aabb box = triangle_bounds(c.mesh, 0);
        if (random_() % 2 == 0) {
            const Vec3 a{coordinate(), coordinate(), coordinate()};
            const Vec3 b{coordinate(), coordinate(), coordinate()};
            const Aabb part{max(box.lower, min(a, b)), min(box.upper, max(a, b))};
            const Vec3 ordered = min(part.lower, part.upper);
            if (ordered == part.lower) box = part;
        }
        c.reference = {{box.lower.x, box.lower.y, box.lower.z}, 0, {box.upper.x, box.upper.y, box.upper.z}, 0};
        return c;
    }

private:
    std::mt19937 random_{11};
};

/// Checks both parts of a cut against the polygon, in double precision; true where all is well.
bool parts_fit(const Case& c, std::size_t axis, float plane, double rounding, double slack) {
    const Reference& reference = c.reference;
    const MeshView mesh = c.mesh;
    const CutReference cut = cut_reference(&mesh, reference, axis, plane);
    const std::vector<Point> polygon = clip_to_box(
        {to_point(c.mesh.vertices[0]), to_point(c.mesh.vertices[1]), to_point(c.mesh.vertices[2])}, reference.bounds());
    for (const bool right : {false, true}) {
        const Aabb part = to_aabb(right ? cut.right : cut.left);
        const std::vector<Point> exact = clip(polygon, axis, plane, right ? -1.0 : 1.0);
        for (const Point& point : exact) {
            if (distance(point, part) > rounding) return false;
        }
        if (!has_point(right ? cut.right : cut.left)) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            const double lower = to_point(part.lower)[k];
            const double upper = to_point(part.upper)[k];
            if (lower < double{reference.lower[k]} || upper > double{reference.upper[k]}) return false;
            if (k == axis && (right ? lower < double{plane} : upper > double{plane})) return false;
        }
        // As tight as the slab between the reference's ends makes it; other sides of the reference may cut off more.
        std::vector<Point> slab{to_point(c.mesh.vertices[0]), to_point(c.mesh.vertices[1]),
                                to_point(c.mesh.vertices[2])};
        slab = clip(slab, axis, right ? double{plane} : double{reference.lower[axis]}, -1.0);
        slab = clip(slab, axis, right ? double{reference.upper[axis]} : double{plane}, 1.0);
        Point least{1e300, 1e300, 1e300};
        Point most{-1e300, -1e300, -1e300};
        for (const Point& point : slab) {
            for (std::size_t k = 0; k < 3; ++k) {
                least[k] = std::min(least[k], point[k]);
                most[k] = std::max(most[k], point[k]);
            }
        }
        for (std::size_t k = 0; k < 3; ++k) {
            if (to_point(part.lower)[k] < least[k] - slack || to_point(part.upper)[k] > most[k] + slack) return false;
        }
    }
    return true;
}

}  // namespace

TEST_CASE("cut references lose nothing and stay tight, at any size and place") {
    struct Place {
        float size, centre;
    };
    CaseSource source;
    for (const Place place : {Place{1.0f, 0.0f}, Place{1e-3f, 1.0f}, Place{1.0f, 1e4f}, Place{0.9e18f, 0.0f},
                              Place{1e-37f, 0.0f}, Place{1e-42f, 0.0f}}) {
        INFO("size " << place.size << " around " << place.centre);
        const double largest = double{place.size} + double{place.centre};
        int wrong = 0;
        for (int round = 0; round < 20000; ++round) {
            const Case c = source.next(place.size, place.centre);
            const auto axis = static_cast<std::size_t>(round % 3);
            const float t = source.between(0.0f, 1.0f);
            const float lower = c.reference.lower[axis];
            const float plane = lower + t * (c.reference.upper[axis] - lower);
            // The oracle rounds in double precision; slack is a few roundings of single precision.
            const double rounding = largest * 0x1p-50;
            const double slack = largest * 0x1p-18 + 200 * double{std::numeric_limits<float>::denorm_min()};
            if (!parts_fit(c, axis, plane, rounding, slack)) ++wrong;
        }
        CHECK(wrong == 0);
    }
}

TEST_CASE("a plane through a corner or beside the triangle leaves an empty part or a touching one") {
    Case c;
    c.mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    c.mesh.triangles = {{0, 1, 2}};
    c.reference = {{0, 0, 0}, 0, {1, 1, 0}, 0};
    const MeshView mesh = c.mesh;
    const CutReference touching = cut_reference(&mesh, c.reference, 0, 1.0f);
    CHECK(to_aabb(touching.left) == Aabb{{0, 0, 0}, {1, 1, 0}});
    CHECK(to_aabb(touching.right) == Aabb{{1, 0, 0}, {1, 0, 0}});
    // The reference's box meets the triangle to the left of the plane only.
    c.reference = {{0, 0.5f, 0}, 0, {1, 1, 0}, 0};
    const CutReference beside = cut_reference(&mesh, c.reference, 0, 0.75f);
    CHECK(has_point(beside.left));
    CHECK_FALSE(has_point(beside.right));
}

TEST_CASE("without a mesh, boxes are cut") {
    const Reference reference{{-1, 2, 3}, 7, {5, 6, 7}, 0};
    const CutReference cut = cut_reference(nullptr, reference, 0, -0.0f);
    CHECK(to_aabb(cut.left) == Aabb{{-1, 2, 3}, {0, 6, 7}});
    CHECK(to_aabb(cut.right) == Aabb{{0, 2, 3}, {5, 6, 7}});
    CHECK_FALSE(std::signbit(cut.left.upper.x()));
    CHECK_FALSE(std::signbit(cut.right.lower.x()));
}
