#pragma once

#include <cstdint>

#include "clbvh/core/aabb.hpp"
#include "clbvh/core/bvh.hpp"
#include "core/negative_zero.hpp"
#include "core/simd/box4.hpp"

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

[[nodiscard]] inline Reference make_reference(const Aabb& box, std::uint32_t primitive) noexcept {
    const Vec3 lower = without_negative_zeros(box.lower);
    const Vec3 upper = without_negative_zeros(box.upper);
    return {{lower.x, lower.y, lower.z}, primitive, {upper.x, upper.y, upper.z}, 0};
}
/// Of a box without negative zeros.
[[nodiscard]] inline Reference make_reference(const Box4& box, std::uint32_t primitive) noexcept {
    Reference reference;
    box.lower.store(reference.lower);  // the fourth lane goes to `primitive`, which is written next
    reference.primitive = primitive;
    box.upper.store(reference.upper);
    reference.unused = 0;
    return reference;
}

/// Extent of a set of references.
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

}  // namespace clbvh::host
