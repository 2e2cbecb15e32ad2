// The clustering, compiled for AVX2.
#include <algorithm>
#include <bit>
#include <limits>
#include <type_traits>

#include "core/simd/avx2.hpp"
#include "core/simd/prefetch.hpp"
#include "host/agglomerative/aac_clustering.hpp"

namespace clbvh::host::aac {
namespace {

#include "host/agglomerative/aac_clustering.ipp"
// Below kFar.
#include "host/agglomerative/aac_small_set.ipp"

}  // namespace

Clusterer clusterer_avx2() noexcept {
    return clusterer_of<simd::avx2::Set, SmallSet>();
}

}  // namespace clbvh::host::aac
