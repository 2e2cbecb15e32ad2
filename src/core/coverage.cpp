// A triangle, or a box, is cut along faces of the boxes until each piece lies wholly inside or outside of every box. A
// piece that is in one box is covered, a piece that is in none is lost. Nothing is ever measured, so triangles without
// an area are proven like all others.
#include "core/coverage.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/polygon_cut.hpp"
#include "core/prefix_sum.hpp"
#include "core/primitive_access.hpp"

namespace clbvh {
namespace {

using Polygon = std::vector<Point>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Box {
    Point lower{kInfinity, kInfinity, kInfinity};
    Point upper{-kInfinity, -kInfinity, -kInfinity};

    [[nodiscard]] bool contains(const Box& other) const {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (!(lower[axis] <= other.lower[axis] && other.upper[axis] <= upper[axis])) return false;
        }
        return true;
    }
    [[nodiscard]] bool touches(const Box& other) const {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (!(lower[axis] <= other.upper[axis] && other.lower[axis] <= upper[axis])) return false;
        }
        return true;
    }
};

Point to_point(const Vec3& v) {
    return {v.x, v.y, v.z};
}

Box bounds_of(const Polygon& polygon) {
    Box box;
    for (const Point& point : polygon) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            box.lower[axis] = std::min(box.lower[axis], point[axis]);
            box.upper[axis] = std::max(box.upper[axis], point[axis]);
        }
    }
    return box;
}

Box bounds_of(const Box& box) {
    return box;
}

Vec3 centre_of(const Box& box) {
    const auto middle = [&](std::size_t axis) {
        return static_cast<float>(0.5 * box.lower[axis] + 0.5 * box.upper[axis]);
    };
    return {middle(0), middle(1), middle(2)};
}

Vec3 centre_of(const Polygon& polygon) {
    Point sum{};
    for (const Point& point : polygon) {
        for (std::size_t axis = 0; axis < 3; ++axis)
            sum[axis] += point[axis] / static_cast<double>(polygon.size());
    }
    return {static_cast<float>(sum[0]), static_cast<float>(sum[1]), static_cast<float>(sum[2])};
}

std::pair<Polygon, Polygon> cut(const Polygon& polygon, const AxisPlane& plane) {
    std::pair<Polygon, Polygon> parts;
    cut_polygon(
        polygon, plane, [&](const Point& point) { parts.first.push_back(point); },
        [&](const Point& point) { parts.second.push_back(point); });
    return parts;
}

std::pair<Box, Box> cut(const Box& box, const AxisPlane& plane) {
    std::pair<Box, Box> parts{box, box};
    parts.first.upper[plane.axis] = plane.position;
    parts.second.lower[plane.axis] = plane.position;
    return parts;
}

/// The middle one of the faces that pass through the inside of `bounds`, along the axis that has most of them; so each
/// part has at most half of them, and cuts nest no deeper than three times the logarithm of the number of faces.
std::optional<AxisPlane> choose_cut(const Box& bounds, std::span<const Box> boxes) {
    std::array<std::vector<double>, 3> faces;
    for (const Box& box : boxes) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (const double face : {box.lower[axis], box.upper[axis]}) {
                if (bounds.lower[axis] < face && face < bounds.upper[axis]) faces[axis].push_back(face);
            }
        }
    }
    const auto most = std::ranges::max_element(faces, {}, &std::vector<double>::size);
    if (most->empty()) return std::nullopt;
    const auto middle = most->begin() + static_cast<std::ptrdiff_t>(most->size() / 2);
    std::ranges::nth_element(*most, middle);
    return AxisPlane{static_cast<std::size_t>(most - faces.begin()), *middle};
}

/// `Piece` is a polygon or a box.
template <typename Piece>
std::optional<Vec3> find_uncovered(const Piece& piece, std::span<const Box> boxes) {
    const Box bounds = bounds_of(piece);
    std::vector<Box> near;
    for (const Box& box : boxes) {
        if (box.contains(bounds)) return std::nullopt;
        if (box.touches(bounds)) near.push_back(box);
    }
    const std::optional<AxisPlane> plane = choose_cut(bounds, near);
    if (!plane) return centre_of(piece);
    const auto [below, above] = cut(piece, *plane);
    if (std::optional<Vec3> point = find_uncovered(below, std::span<const Box>(near))) return point;
    return find_uncovered(above, std::span<const Box>(near));
}

std::vector<Box> grown(std::span<const Aabb> boxes, double by) {
    std::vector<Box> result;
    result.reserve(boxes.size());
    for (const Aabb& box : boxes) {
        Box& target = result.emplace_back(Box{to_point(box.lower), to_point(box.upper)});
        for (std::size_t axis = 0; axis < 3; ++axis) {
            target.lower[axis] -= by;
            target.upper[axis] += by;
        }
    }
    return result;
}

/// For each primitive the leaves that name it.
class LeafLists {
public:
    LeafLists(const Bvh& bvh, std::span<const std::uint32_t> leaves) : begins_(bvh.primitive_count + 1, 0) {
        // Begins are counted one place too far, and come to stand where they belong while the lists are filled.
        for_each_reference(bvh, leaves, [&](std::uint32_t primitive, std::uint32_t) { ++begins_[primitive + 1]; });
        leaves_.resize(sum_before(std::span(begins_)));
        for_each_reference(bvh, leaves, [&](std::uint32_t primitive, std::uint32_t leaf) {
            leaves_[begins_[primitive + 1]++] = leaf;
        });
    }

    [[nodiscard]] std::span<const std::uint32_t> operator[](std::size_t primitive) const {
        return {leaves_.data() + begins_[primitive], leaves_.data() + begins_[primitive + 1]};
    }

private:
    template <typename Visit>
    static void for_each_reference(const Bvh& bvh, std::span<const std::uint32_t> leaves, const Visit& visit) {
        for (const std::uint32_t leaf : leaves) {
            const Node& node = bvh.nodes[leaf];
            for (std::size_t slot = node.first; slot < std::size_t{node.first} + node.count; ++slot)
                visit(bvh.primitive_ids[slot], leaf);
        }
    }

    std::vector<std::uint64_t> begins_;
    std::vector<std::uint32_t> leaves_;
};

}  // namespace

std::optional<Vec3> find_uncovered_point(const std::array<Vec3, 3>& triangle, std::span<const Aabb> boxes) {
    const Polygon polygon{to_point(triangle[0]), to_point(triangle[1]), to_point(triangle[2])};
    double largest = 0.0;
    for (const Point& point : polygon) {
        for (const double coordinate : point)
            largest = std::max(largest, std::abs(coordinate));
    }
    return find_uncovered(polygon, std::span<const Box>(grown(boxes, kCoverageTolerance * largest)));
}

std::optional<Vec3> find_uncovered_point(const Aabb& whole, std::span<const Aabb> boxes) {
    const Box box{to_point(whole.lower), to_point(whole.upper)};
    return find_uncovered(box, std::span<const Box>(grown(boxes, 0.0)));
}

std::optional<LostPart> find_lost_part(const Bvh& bvh, const Primitives& primitives,
                                       std::span<const std::uint32_t> leaves) {
    constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
    const LeafLists lists(bvh, leaves);
    const auto uncovered_point = [&](std::size_t primitive) -> std::optional<Vec3> {
        if (is_inactive_primitive(primitives, primitive)) return std::nullopt;
        const Aabb whole = primitive_bounds(primitives, primitive);
        std::vector<Aabb> boxes;
        for (const std::uint32_t leaf : lists[primitive]) {
            const Aabb box = bvh.nodes[leaf].bounds();
            if (merge(box, whole) == box) return std::nullopt;
            boxes.push_back(box);
        }
        const auto* const mesh = std::get_if<MeshView>(&primitives);
        if (mesh == nullptr) return find_uncovered_point(whole, boxes);
        const auto [a, b, c] = mesh->triangle(primitive);
        return find_uncovered_point({mesh->vertex(a), mesh->vertex(b), mesh->vertex(c)}, boxes);
    };
    const std::size_t first_lost = tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, count_of(primitives), 512), none,
        [&](const auto& range, std::size_t best) {
            for (std::size_t i = range.begin(); i < range.end() && i < best; ++i) {
                if (uncovered_point(i)) best = i;
            }
            return best;
        },
        [](std::size_t a, std::size_t b) { return std::min(a, b); });
    if (first_lost == none) return std::nullopt;
    return LostPart{first_lost, *uncovered_point(first_lost)};
}

}  // namespace clbvh
