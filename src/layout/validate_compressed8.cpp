#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string>
#include <vector>

#include "clbvh/layout/compressed8.hpp"
#include "core/tree_walk.hpp"
#include "layout/leaf_check.hpp"
#include "layout/quantized_boxes.hpp"

namespace clbvh {
namespace {

using namespace layout;

/// A plane of a grid, as floats see it: the least that is not below, and the largest that is not above.
struct Plane {
    /// At origin + distance, exactly.
    Plane(float origin, float distance) {
        const double a = origin, b = distance;
        const double sum = a + b;
        const double from_b = sum - a;
        const double error = (a - (sum - from_b)) + (b - from_b);
        const auto nearest = static_cast<float>(sum);
        const double at = nearest;
        const bool is_below = at < sum || (at == sum && error > 0.0);
        const bool is_above = at > sum || (at == sum && error < 0.0);
        above = is_below ? std::nextafter(nearest, kPositiveInfinity) : nearest;
        below = is_above ? std::nextafter(nearest, kNegativeInfinity) : nearest;
    }
    float above = 0.0f, below = 0.0f;
};

/// The largest box of floats within the exact box of the child in `slot`. A triangle is in the one if it is in the
/// other.
Aabb inner_bounds(const Compressed8Node& node, std::uint32_t slot) {
    std::array<float, 3> lower{}, upper{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const float step = power_of_two(node.exponent[axis]);
        lower[axis] = Plane(node.origin[axis], static_cast<float>(node.lower[axis][slot]) * step).above;
        upper[axis] = Plane(node.origin[axis], static_cast<float>(node.upper[axis][slot]) * step).below;
    }
    return {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}};
}

/// Goes over the nodes from the root. Boxes are taken together on the way: the box of a leaf, for a ray, is what it has
/// in common with all boxes above it.
class Compressed8Check {
public:
    Compressed8Check(const Compressed8& layout, const MeshView& mesh)
        : layout_(layout),
          mesh_(mesh),
          leaves_(mesh, layout.primitive_count, layout.split_references, true),
          is_reached_(layout.nodes.size(), false),
          is_used_(layout.triangles.size(), false) {}

    void run() {
        std::uint32_t depth = 0;
        if (!layout_.empty())
            push(0,
                 {{kNegativeInfinity, kNegativeInfinity, kNegativeInfinity},
                  {kPositiveInfinity, kPositiveInfinity, kPositiveInfinity}},
                 1);
        while (!open_.empty()) {
            const Open open = open_.back();
            open_.pop_back();
            depth = std::max(depth, open.depth);
            enter(open);
        }
        reject_unused(is_reached_, "node");
        reject_unused(is_used_, "triangle");
        check_depth(layout_.depth, depth);
        leaves_.finish();
    }

private:
    struct Open {
        std::size_t node;
        Aabb box;
        std::uint32_t depth;
    };

    void push(std::size_t node, const Aabb& box, std::uint32_t depth) {
        is_reached_[node] = true;
        open_.push_back({node, box, depth});
    }

    void enter(const Open& open) {
        const Compressed8Node& node = layout_.nodes[open.node];
        for (const std::int8_t exponent : node.exponent) {
            if (exponent < kLeastExponent)
                reject_layout(name_node(open.node) + ": an exponent is " + std::to_string(exponent));
        }
        std::uint32_t triangles = 0;  // of the node
        for (std::uint32_t slot = 0; slot < 8; ++slot) {
            if (node.is_empty(slot) && !node.is_inner(slot)) continue;
            const Aabb own = inner_bounds(node, slot);
            const Aabb box{(max)(own.lower, open.box.lower), (min)(own.upper, open.box.upper)};
            if (node.is_inner(slot)) {
                enter_child(open, slot, box);
            } else {
                triangles += enter_leaf(open.node, slot, triangles, box);
            }
        }
        if (triangles == 0 && node.first_triangle != 0)
            reject_layout(name_node(open.node) + ": it has a first triangle, but no leaf");
    }

    void enter_child(const Open& open, std::uint32_t slot, const Aabb& box) {
        const Compressed8Node& node = layout_.nodes[open.node];
        const std::uint32_t child = node.child(slot);
        if (node.meta[slot] != (1U << 5U | (24 + slot))) reject_meta(open.node, slot);
        if (child >= layout_.nodes.size()) {
            reject_layout(name_node(open.node) + ": its child " + std::to_string(child) +
                          " is out of range (there are " + std::to_string(layout_.nodes.size()) + " nodes)");
        }
        if (is_reached_[child])
            reject_layout(name_node(open.node) + ": its child " + std::to_string(child) + " has another parent");
        push(child, box, open.depth + 1);
    }

    /// Returns how many triangles the leaf has; those in slots before it have `before`.
    std::uint32_t enter_leaf(std::size_t index, std::uint32_t slot, std::uint32_t before, const Aabb& box) {
        const Compressed8Node& node = layout_.nodes[index];
        const std::uint32_t count = node.triangle_count(slot), first = node.triangle(slot);
        const std::uint32_t ones = node.meta[slot] >> 5U;
        if ((ones & (ones + 1)) != 0 || ones == 0 || (node.meta[slot] & 31U) != before) reject_meta(index, slot);
        if (node.first_triangle % 3 != 0 || std::size_t{first} + count > layout_.triangles.size()) {
            reject_layout(name_node(index) + ": its first triangle " + std::to_string(node.first_triangle) +
                          " is no multiple of 3, or too far behind for the triangles of slot " + std::to_string(slot));
        }
        std::array<std::uint32_t, 3> ids{};
        for (std::uint32_t i = 0; i < count; ++i) {
            if (is_used_[first + i])
                reject_layout(name_node(index) + ": triangle " + std::to_string(first + i) + " is in another leaf");
            is_used_[first + i] = true;
            ids[i] = layout_.triangles[first + i].primitive;
        }
        leaves_.add(index, box, std::span(ids).first(count), slot);
        for (std::uint32_t i = 0; i < count; ++i)
            check_triangle(first + i);
        return count;
    }

    [[noreturn]] void reject_meta(std::size_t node, std::uint32_t slot) const {
        reject_layout(name_node(node) + ": meta of slot " + std::to_string(slot) + " is " +
                      std::to_string(layout_.nodes[node].meta[slot]));
    }

    /// Its primitive is in range.
    void check_triangle(std::size_t index) const {
        const Compressed8Triangle& triangle = layout_.triangles[index];
        const auto [a, b, c] = mesh_.triangle(triangle.primitive);
        const Vec3 v0 = mesh_.vertex(a), v1 = mesh_.vertex(b), v2 = mesh_.vertex(c);
        using Floats = std::array<float, 3>;
        if (triangle.vertex0 != Floats{v0.x, v0.y, v0.z} ||
            triangle.edge1 != Floats{v1.x - v0.x, v1.y - v0.y, v1.z - v0.z} ||
            triangle.edge2 != Floats{v2.x - v0.x, v2.y - v0.y, v2.z - v0.z}) {
            reject_layout("triangle " + std::to_string(index) + ": it is not that of primitive " +
                          std::to_string(triangle.primitive));
        }
    }

    const Compressed8& layout_;
    MeshView mesh_;
    LeafCheck leaves_;
    std::vector<bool> is_reached_, is_used_;  ///< One per node, one per triangle.
    std::vector<Open> open_;
};

}  // namespace

void validate(const Compressed8& layout, const MeshView& mesh) {
    Compressed8Check(layout, mesh).run();
}

}  // namespace clbvh
