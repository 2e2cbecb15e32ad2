// The loops for every processor, and the choice between them and those of binning_loops_avx2.cpp.
#include "host/top_down/binning_loops.hpp"

#include <algorithm>
#include <bit>

#include "core/simd/box8.hpp"
#include "core/simd/dispatch.hpp"
#include "core/simd/scalar.hpp"

namespace clbvh::host {
namespace {

#include "host/top_down/binning_loops.ipp"

}  // namespace

const BinningLoops& binning_loops() noexcept {
    const simd::InstructionSet set = simd::instruction_set();
#if defined(CLBVH_HAS_AVX2)
    if (set == simd::InstructionSet::avx2) return kBinningLoopsAvx2;
#endif
    return set == simd::InstructionSet::scalar ? kLoops<simd::scalar::Set> : kLoops<simd::baseline::Set>;
}

}  // namespace clbvh::host
