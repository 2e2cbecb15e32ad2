#pragma once

#include <cstdint>
#include <limits>

#include "clbvh/core/bvh.hpp"
#include "core/simd/float4.hpp"

namespace clbvh {

/// A box in registers. Default-constructed empty: merging anything into it gives that thing.
struct Box4 {
    Float4 lower = Float4::filled(std::numeric_limits<float>::infinity());
    Float4 upper = Float4::filled(-std::numeric_limits<float>::infinity());

    /// That of a Node, or of anything else with `lower` and `upper`, each with a word behind it.
    template <typename Boxed>
    [[nodiscard]] static CLBVH_ALWAYS_INLINE Box4 of(const Boxed& boxed) noexcept {
        return {Float4::load(boxed.lower), Float4::load(boxed.upper)};
    }
    CLBVH_ALWAYS_INLINE void merge(const Box4& other) noexcept {
        lower = min(lower, other.lower);
        upper = max(upper, other.upper);
    }
    CLBVH_ALWAYS_INLINE void merge(Float4 point) noexcept {
        lower = min(lower, point);
        upper = max(upper, point);
    }
    /// Twice the centre, as doubled_centroid() gives it, with 0 in the fourth lane.
    [[nodiscard]] CLBVH_ALWAYS_INLINE Float4 doubled_centroid() const noexcept {
        return lower.without_w() + upper.without_w();
    }
    [[nodiscard]] CLBVH_ALWAYS_INLINE float half_area() const noexcept { return half_area_of_extents(upper - lower); }
};

/// A node with this box.
[[nodiscard]] CLBVH_ALWAYS_INLINE Node make_node(const Box4& box, std::uint32_t first, std::uint32_t count) noexcept {
    Node node;
    // Whole vectors: a node that is copied soon would wait for stores of single words. The fourth lane goes behind the
    // corner.
    box.lower.with_w(first).store(node.lower);
    box.upper.with_w(count).store(node.upper);
    return node;
}

}  // namespace clbvh
