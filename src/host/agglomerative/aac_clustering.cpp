// The clustering of aac_clustering.ipp, compiled for several instruction sets, and the choice between them.
#include "host/agglomerative/aac_clustering.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "core/simd/prefetch.hpp"

#if defined(CLBVH_HAS_SSE2) && defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define CLBVH_AAC_HAS_AVX2 1
#include <immintrin.h>
#endif

namespace clbvh::host::aac {
namespace {

/// The distance where there is no other cluster.
constexpr float kFar = std::numeric_limits<float>::infinity();

namespace scalar {
#define CLBVH_AAC_LANES 1
#include "host/agglomerative/aac_lanes.ipp"
// Written in terms of the lanes.
#include "host/agglomerative/aac_clustering.ipp"
#undef CLBVH_AAC_LANES
}  // namespace scalar

#if defined(CLBVH_HAS_SSE2)
namespace sse2 {
#define CLBVH_AAC_LANES 4
#include "host/agglomerative/aac_lanes.ipp"
// Written in terms of the lanes.
#include "host/agglomerative/aac_clustering.ipp"
#undef CLBVH_AAC_LANES
}  // namespace sse2
#endif

#if defined(CLBVH_AAC_HAS_AVX2)
// Everything between is compiled for AVX2 and is in a namespace of its own, so no other code can come to use it.
#pragma GCC push_options
#pragma GCC target("avx2,bmi,bmi2,lzcnt")
namespace avx2 {
#define CLBVH_AAC_LANES 8
#define CLBVH_AAC_HAS_SMALL_SETS 1
#include "host/agglomerative/aac_lanes.ipp"
// Written in terms of the lanes.
#include "host/agglomerative/aac_small_set.ipp"
// Written in terms of both.
#include "host/agglomerative/aac_clustering.ipp"
#undef CLBVH_AAC_HAS_SMALL_SETS
#undef CLBVH_AAC_LANES
}  // namespace avx2
#pragma GCC pop_options
#endif

}  // namespace

bool is_available(InstructionSet set) noexcept {
    switch (set) {
        case InstructionSet::scalar: return true;
        case InstructionSet::sse2:
#if defined(CLBVH_HAS_SSE2)
            return true;
#else
            return false;
#endif
        case InstructionSet::avx2:
#if defined(CLBVH_AAC_HAS_AVX2)
            return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") &&
                   __builtin_cpu_supports("lzcnt");
#else
            return false;
#endif
    }
    return false;
}

InstructionSet best_instruction_set() noexcept {
    if (is_available(InstructionSet::avx2)) return InstructionSet::avx2;
    if (is_available(InstructionSet::sse2)) return InstructionSet::sse2;
    return InstructionSet::scalar;
}

template <typename Code>
Clusterer<Code> clusterer([[maybe_unused]] InstructionSet set) noexcept {
#if defined(CLBVH_AAC_HAS_AVX2)
    if (set == InstructionSet::avx2) return avx2::clusterer<Code>();
#endif
#if defined(CLBVH_HAS_SSE2)
    if (set == InstructionSet::sse2) return sse2::clusterer<Code>();
#endif
    return scalar::clusterer<Code>();
}

template Clusterer<std::uint32_t> clusterer(InstructionSet) noexcept;
template Clusterer<std::uint64_t> clusterer(InstructionSet) noexcept;

}  // namespace clbvh::host::aac
