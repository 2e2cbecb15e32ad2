#pragma once

#include "core/simd/box4.hpp"

namespace clbvh::simd {

/// A box as its lower corner and its upper corner with the sign turned, so that one minimum merges two boxes. `Set` is
/// the Set of the instruction set that the code around it is compiled for.
template <typename Set>
struct Box8 {
    using Float4 = typename Set::Float4;
    using Float8 = typename Set::Float8;

    Float8 lanes;

    /// That of 32 aligned bytes: the lower corner, a word, the upper corner, a word.
    template <typename Boxed>
    static CLBVH_ALWAYS_INLINE Box8 of(const Boxed& boxed) noexcept {
        static_assert(sizeof(Boxed) == 32 && alignof(Boxed) == 32);
        return {Float8::load_aligned(reinterpret_cast<const float*>(&boxed)).with_negated_high_half()};
    }
    static CLBVH_ALWAYS_INLINE Box8 load(const float* source) noexcept { return {Float8::load_aligned(source)}; }
    CLBVH_ALWAYS_INLINE void store(float* target) const noexcept { lanes.store_aligned(target); }
    CLBVH_ALWAYS_INLINE void merge(const Box8& other) noexcept { lanes = min(lanes, other.lanes); }
    /// The same box where `penalty` is 0; where it is infinite, one that changes nothing it is merged into.
    [[nodiscard]] CLBVH_ALWAYS_INLINE Box8 penalized(float penalty) const noexcept {
        return {lanes + Float8::filled(penalty)};
    }
    /// The box of twice the centre.
    [[nodiscard]] CLBVH_ALWAYS_INLINE Box8 doubled_centroid() const noexcept {
        const Float4 centroid = lanes.low_half().without_w() - lanes.high_half().without_w();
        return {Float8::of_halves(centroid, centroid.negated())};
    }
    [[nodiscard]] CLBVH_ALWAYS_INLINE Float4 negated_extents() const noexcept {
        return lanes.low_half() + lanes.high_half();
    }
};

}  // namespace clbvh::simd
