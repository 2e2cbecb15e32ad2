#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"
#include "clbvh/core/ray.hpp"
#include "clbvh/trace/box_tests.hpp"
#include "trace/triangle_tests.hpp"

// What happens in the leaves of a binary tree: visitors for traverse(). Each works on triangles in the order of
// Bvh::primitive_ids, so that leaves refer to them as they refer to ids.
namespace clbvh::trace {

/// A copy of a triangle, beside its neighbours in the leaf.
struct LeafTriangle {
    TriangleVertices vertices;
    std::uint32_t primitive;
};

/// The triangles of `mesh` in the order of the tree's primitive ids, which are in range.
[[nodiscard]] std::vector<LeafTriangle> copy_triangles(const Bvh& bvh, const MeshView& mesh);

/// Whether `hit` is the closest so far; a hit that is none counts as infinitely far.
[[nodiscard]] inline bool is_closer(float t, std::uint32_t primitive, const Hit& hit) noexcept {
    return t < hit.t || (t == hit.t && primitive < hit.primitive);
}

/// What makes a place where the ray's line meets a triangle a hit: it is on the ray, and the ray meets the triangle's
/// own box. Rounding can put it before that box, where a long thin triangle begins close to the ray's origin; then the
/// hit is where the ray enters the box. So whatever may hide a box may hide all hits in it, and the closest hit does
/// not depend on the tree.
class HitRule {
public:
    explicit HitRule(const Ray& ray) noexcept : slabs_(ray), t_max_(ray.t_max) {}

    [[nodiscard]] const RaySlabs& slabs() const noexcept { return slabs_; }
    [[nodiscard]] float t_min() const noexcept { return slabs_.t_min(); }
    [[nodiscard]] float t_max() const noexcept { return t_max_; }

    /// Turns what a triangle test found into a hit, if it is one; it may move t.
    [[nodiscard]] CLBVH_ALWAYS_INLINE std::optional<PlaneHit> accept(const TriangleVertices& triangle,
                                                                     std::optional<PlaneHit> found) const noexcept {
        if (!found || !(slabs_.t_min() <= found->t && found->t <= t_max_)) return std::nullopt;
        const Aabb box{min(min(triangle.v0, triangle.v1), triangle.v2),
                       max(max(triangle.v0, triangle.v1), triangle.v2)};
        const float entry = slabs_.entry(box);
        if (!(entry <= slabs_.exit(box, t_max_) * kBoxSlack)) return std::nullopt;
        if (entry <= found->t * kBoxSlack) return found;
        found->t = entry;
        return entry <= t_max_ ? found : std::nullopt;
    }

private:
    RaySlabs slabs_;
    float t_max_;
};

/// Finds the closest hit.
template <typename Test>
class ClosestLeaf {
public:
    ClosestLeaf(const LeafTriangle* triangles, const Ray& ray) : triangles_(triangles), test_(ray), rule_(ray) {}

    bool operator()(std::uint32_t first, std::uint32_t count, float& t_max) {
        tested_ += count;
        for (const LeafTriangle& triangle : std::span(triangles_ + first, count)) {
            const auto found = rule_.accept(triangle.vertices, test_.meet(triangle.vertices));
            if (!found) continue;
            if (!is_closer(found->t, triangle.primitive, hit_)) continue;
            hit_ = {found->t, found->u, found->v, triangle.primitive};
            t_max = found->t;
        }
        return true;
    }

    [[nodiscard]] const Hit& hit() const noexcept { return hit_; }
    [[nodiscard]] std::uint32_t tested() const noexcept { return tested_; }

private:
    const LeafTriangle* triangles_;
    Test test_;
    HitRule rule_;
    Hit hit_;
    std::uint32_t tested_ = 0;
};

/// Finds out whether there is a hit.
template <typename Test>
class AnyLeaf {
public:
    AnyLeaf(const LeafTriangle* triangles, const Ray& ray) : triangles_(triangles), test_(ray), rule_(ray) {}

    bool operator()(std::uint32_t first, std::uint32_t count, float&) {
        for (const LeafTriangle& triangle : std::span(triangles_ + first, count)) {
            ++tested_;
            is_hit_ = rule_.accept(triangle.vertices, test_.meet(triangle.vertices)).has_value();
            if (is_hit_) return false;
        }
        return true;
    }

    [[nodiscard]] bool is_hit() const noexcept { return is_hit_; }
    [[nodiscard]] std::uint32_t tested() const noexcept { return tested_; }

private:
    const LeafTriangle* triangles_;
    Test test_;
    HitRule rule_;
    bool is_hit_ = false;
    std::uint32_t tested_ = 0;
};

}  // namespace clbvh::trace
