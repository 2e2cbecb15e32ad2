#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "clbvh/core/ray.hpp"
#include "trace/triangle_tests.hpp"

// What happens in the leaves of a binary tree: visitors for traverse(). Each works on triangles in the order of
// Bvh::primitive_ids, so that leaves refer to them as they refer to ids.
namespace clbvh::trace {

/// A copy of a triangle, beside its neighbours in the leaf.
struct LeafTriangle {
    TriangleVertices vertices;
    std::uint32_t primitive;
};

/// Whether `hit` is the closest so far; a hit that is none counts as infinitely far.
[[nodiscard]] inline bool is_closer(float t, std::uint32_t primitive, const Hit& hit) noexcept {
    return t < hit.t || (t == hit.t && primitive < hit.primitive);
}

/// The part of a ray that may hit something.
struct RayRange {
    explicit RayRange(const Ray& ray) noexcept : least(ray.t_min > 0.0f ? ray.t_min : 0.0f), most(ray.t_max) {}
    [[nodiscard]] bool contains(float t) const noexcept { return least <= t && t <= most; }

    float least, most;
};

/// Finds the closest hit.
template <typename Test>
class ClosestLeaf {
public:
    ClosestLeaf(const LeafTriangle* triangles, const Ray& ray) : triangles_(triangles), test_(ray), range_(ray) {}

    bool operator()(std::uint32_t first, std::uint32_t count, float& t_max) {
        tested_ += count;
        for (const LeafTriangle& triangle : std::span(triangles_ + first, count)) {
            PlaneHit found;
            if (!test_.meets(triangle.vertices, found) || !range_.contains(found.t)) continue;
            if (!is_closer(found.t, triangle.primitive, hit_)) continue;
            hit_ = {found.t, found.u, found.v, triangle.primitive};
            t_max = found.t;
        }
        return true;
    }

    [[nodiscard]] const Hit& hit() const noexcept { return hit_; }
    [[nodiscard]] std::uint32_t tested() const noexcept { return tested_; }

private:
    const LeafTriangle* triangles_;
    Test test_;
    RayRange range_;
    Hit hit_;
    std::uint32_t tested_ = 0;
};

/// Finds out whether there is a hit.
template <typename Test>
class AnyLeaf {
public:
    AnyLeaf(const LeafTriangle* triangles, const Ray& ray) : triangles_(triangles), test_(ray), range_(ray) {}

    bool operator()(std::uint32_t first, std::uint32_t count, float&) {
        for (const LeafTriangle& triangle : std::span(triangles_ + first, count)) {
            ++tested_;
            PlaneHit found;
            is_hit_ = test_.meets(triangle.vertices, found) && range_.contains(found.t);
            if (is_hit_) return false;
        }
        return true;
    }

    [[nodiscard]] bool is_hit() const noexcept { return is_hit_; }
    [[nodiscard]] std::uint32_t tested() const noexcept { return tested_; }

private:
    const LeafTriangle* triangles_;
    Test test_;
    RayRange range_;
    bool is_hit_ = false;
    std::uint32_t tested_ = 0;
};

/// Collects all hits.
template <typename Test>
class AllLeaf {
public:
    AllLeaf(const LeafTriangle* triangles, const Ray& ray) : triangles_(triangles), test_(ray), range_(ray) {}

    bool operator()(std::uint32_t first, std::uint32_t count, float&) {
        for (const LeafTriangle& triangle : std::span(triangles_ + first, count)) {
            PlaneHit found;
            if (!test_.meets(triangle.vertices, found) || !range_.contains(found.t)) continue;
            hits_.push_back({found.t, found.u, found.v, triangle.primitive});
        }
        return true;
    }

    /// Ordered by t, then by primitive; each primitive once.
    [[nodiscard]] std::vector<Hit> take_hits() {
        std::ranges::sort(hits_, [](const Hit& a, const Hit& b) { return is_closer(a.t, a.primitive, b); });
        hits_.erase(std::ranges::unique(hits_, {}, &Hit::primitive).begin(), hits_.end());
        return std::move(hits_);
    }

private:
    const LeafTriangle* triangles_;
    Test test_;
    RayRange range_;
    std::vector<Hit> hits_;
};

}  // namespace clbvh::trace
