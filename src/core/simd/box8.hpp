#pragma once

#include <cstdint>

#include "host/build/reference.hpp"

// Two implementations of the same eight lanes. A function that is compiled for AVX2 uses Box8Avx, every other one
// Box8Pair; both give the same bits.
#if defined(CLBVH_HAS_SSE2) && defined(__x86_64__) && defined(__GNUC__)
#define CLBVH_HAS_AVX2_FUNCTIONS 1
#define CLBVH_AVX2_FUNCTION __attribute__((target("avx2,popcnt")))
#endif
// Lanes of eight floats stay within such functions: no call passes them.
#define CLBVH_ALWAYS_INLINE inline __attribute__((always_inline))

namespace clbvh::host {

/// True where CLBVH_AVX2_FUNCTIONs are called; tests turn it off to try the others.
#if defined(CLBVH_HAS_AVX2_FUNCTIONS)
inline bool use_avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("popcnt");
#else
inline bool use_avx2 = false;
#endif

/// A box as its lower corner and its upper corner with the sign turned, so that one minimum merges two boxes; in two
/// registers.
struct Box8Pair {
    Float4 lower, negated_upper;

    static CLBVH_ALWAYS_INLINE Box8Pair of(const Reference& reference) noexcept {
        return {Float4::load(reference.lower), Float4::load(reference.upper).negated()};
    }
    static CLBVH_ALWAYS_INLINE Box8Pair load(const float* source) noexcept {
        return {Float4::load(source), Float4::load(source + 4)};
    }
    CLBVH_ALWAYS_INLINE void store(float* target) const noexcept {
        lower.store(target);
        negated_upper.store(target + 4);
    }
    CLBVH_ALWAYS_INLINE void merge(const Box8Pair& other) noexcept {
        lower = min(lower, other.lower);
        negated_upper = min(negated_upper, other.negated_upper);
    }
    /// The same box where `penalty` is 0; where it is infinite, one that changes nothing it is merged into.
    [[nodiscard]] CLBVH_ALWAYS_INLINE Box8Pair penalized(float penalty) const noexcept {
        const Float4 added = Float4::filled(penalty);
        return {lower + added, negated_upper + added};
    }
    /// The box of twice the centre.
    [[nodiscard]] CLBVH_ALWAYS_INLINE Box8Pair doubled_centroid() const noexcept {
        const Float4 centroid = lower.without_w() - negated_upper.without_w();
        return {centroid, centroid.negated()};
    }
    [[nodiscard]] CLBVH_ALWAYS_INLINE Float4 negated_extents() const noexcept { return lower + negated_upper; }
};

#if defined(CLBVH_HAS_AVX2_FUNCTIONS)
// Everything here is inlined into functions that are compiled for AVX2: no call passes these lanes.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// The same in one register, for CLBVH_AVX2_FUNCTIONs alone.
struct Box8Avx {
    using Lanes [[gnu::vector_size(32), gnu::may_alias]] = float;
    using Bits [[gnu::vector_size(32), gnu::may_alias]] = std::uint32_t;
    Lanes lanes;

    static CLBVH_ALWAYS_INLINE Box8Avx of(const Reference& reference) noexcept {
        constexpr std::uint32_t sign = 0x80000000u;
        return {reinterpret_cast<Lanes>(*reinterpret_cast<const Bits*>(&reference) ^
                                        Bits{0, 0, 0, 0, sign, sign, sign, sign})};
    }
    static CLBVH_ALWAYS_INLINE Box8Avx load(const float* source) noexcept {
        return {*reinterpret_cast<const Lanes*>(source)};
    }
    CLBVH_ALWAYS_INLINE void store(float* target) const noexcept { *reinterpret_cast<Lanes*>(target) = lanes; }
    CLBVH_ALWAYS_INLINE void merge(const Box8Avx& other) noexcept { lanes = lanes < other.lanes ? lanes : other.lanes; }
    [[nodiscard]] CLBVH_ALWAYS_INLINE Box8Avx penalized(float penalty) const noexcept { return {lanes + penalty}; }
    [[nodiscard]] CLBVH_ALWAYS_INLINE Box8Avx doubled_centroid() const noexcept {
        const Float4 lower{__builtin_shufflevector(lanes, lanes, 0, 1, 2, 3)};
        const Float4 negated_upper{__builtin_shufflevector(lanes, lanes, 4, 5, 6, 7)};
        const Float4 centroid = lower.without_w() - negated_upper.without_w();
        return {__builtin_shufflevector(centroid.lanes, centroid.negated().lanes, 0, 1, 2, 3, 4, 5, 6, 7)};
    }
    [[nodiscard]] CLBVH_ALWAYS_INLINE Float4 negated_extents() const noexcept {
        return Float4{__builtin_shufflevector(lanes, lanes, 0, 1, 2, 3)} +
               Float4{__builtin_shufflevector(lanes, lanes, 4, 5, 6, 7)};
    }
};

#pragma GCC diagnostic pop
#endif

}  // namespace clbvh::host
