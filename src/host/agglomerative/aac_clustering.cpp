// The clustering for every processor, and the choice between it and that of aac_clustering_avx2.cpp.
#include "host/agglomerative/aac_clustering.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <type_traits>

#include "core/simd/float4.hpp"
#include "core/simd/prefetch.hpp"
#include "core/simd/scalar.hpp"

namespace clbvh::host::aac {
namespace {

#include "host/agglomerative/aac_clustering.ipp"

}  // namespace

template <typename Code>
Clusterer<Code> clusterer(simd::InstructionSet set) noexcept {
#if defined(CLBVH_HAS_AVX2)
    if (set == simd::InstructionSet::avx2) return clusterer_avx2<Code>();
#endif
    if (set == simd::InstructionSet::scalar) return clusterer_of<simd::scalar::Set, void, Code>();
    return clusterer_of<simd::baseline::Set, void, Code>();
}

template Clusterer<std::uint32_t> clusterer(simd::InstructionSet) noexcept;
template Clusterer<std::uint64_t> clusterer(simd::InstructionSet) noexcept;

}  // namespace clbvh::host::aac
