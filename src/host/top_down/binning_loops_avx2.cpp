// The loops, compiled for AVX2.
#include <algorithm>
#include <bit>

#include "core/simd/avx2.hpp"
#include "core/simd/box8.hpp"
#include "host/top_down/binning_loops.hpp"

namespace clbvh::host {
namespace {

#include "host/top_down/binning_loops.ipp"

}  // namespace

const BinningLoops kBinningLoopsAvx2 = kLoops<simd::avx2::Set>;

}  // namespace clbvh::host
