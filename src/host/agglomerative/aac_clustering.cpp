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

Clusterer clusterer(simd::InstructionSet set) noexcept {
#if defined(CLBVH_HAS_AVX2)
    if (set == simd::InstructionSet::avx2) return clusterer_avx2();
#endif
    if (set == simd::InstructionSet::scalar) return clusterer_of<simd::scalar::Set, void>();
    return clusterer_of<simd::baseline::Set, void>();
}

}  // namespace clbvh::host::aac
