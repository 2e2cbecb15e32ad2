#pragma once

#include <cstdint>
#include <limits>

#include "clbvh/core/aabb.hpp"
#include "clbvh/core/bvh.hpp"
#include "host/float4.hpp"

namespace clbvh::host {

/// A primitive, or a part of one, as the builders move it around: its box and its id. Half a cache line.
/// No coordinate is -0, so that unions are the same bits in whatever order they are taken.
struct alignas(32) Reference {
    float lower[3];
    std::uint32_t primitive;
    float upper[3];
    std::uint32_t unused;

    [[nodiscard]] Aabb bounds() const noexcept {
        return {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}};
    }
};
static_assert(sizeof(Reference) == 32);

/// A box in registers. Default-constructed empty: merging anything into it gives that thing.
struct Box4 {
    Float4 lower = Float4::filled(std::numeric_limits<float>::infinity());
    Float4 upper = Float4::filled(-std::numeric_limits<float>::infinity());

    [[nodiscard]] static Box4 of(const Reference& reference) noexcept {
        return {Float4::load(reference.lower), Float4::load(reference.upper)};
    }
    void merge(const Box4& other) noexcept {
        lower = min(lower, other.lower);
        upper = max(upper, other.upper);
    }
    void merge(Float4 point) noexcept {
        lower = min(lower, point);
        upper = max(upper, point);
    }
    /// Twice the centre, as doubled_centroid() gives it, with 0 in the fourth lane.
    [[nodiscard]] Float4 doubled_centroid() const noexcept { return lower.without_w() + upper.without_w(); }
    [[nodiscard]] float half_area() const noexcept { return half_area_of_extents(upper - lower); }
};

/// What a set of references takes up.
struct Bounds {
    Box4 box;
    Box4 centroids;  ///< Bounds of the doubled centroids.

    void add(const Reference& reference) noexcept {
        const Box4 reference_box = Box4::of(reference);
        box.merge(reference_box);
        centroids.merge(reference_box.doubled_centroid());
    }
    void add(const Bounds& bounds) noexcept {
        box.merge(bounds.box);
        centroids.merge(bounds.centroids);
    }
};

/// A node with this box.
[[nodiscard]] inline Node make_node(const Box4& box, std::uint32_t first, std::uint32_t count) noexcept {
    Node node;
    // Whole vectors: a node that is copied soon would wait for stores of single words. The fourth lane goes behind the
    // corner.
    box.lower.with_w(first).store(node.lower);
    box.upper.with_w(count).store(node.upper);
    return node;
}

}  // namespace clbvh::host
