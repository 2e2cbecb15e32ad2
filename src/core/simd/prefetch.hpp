#pragma once

#include "core/simd/always_inline.hpp"

namespace clbvh {

/// Asks for a cache line that is needed soon. What walks a tree takes several nodes at once and asks for the children
/// of all of them first, so that their misses overlap; what streams asks some kilobytes ahead, since not every
/// processor does that by itself.
CLBVH_ALWAYS_INLINE void prefetch([[maybe_unused]] const void* address) noexcept {
#if defined(__GNUC__)
    __builtin_prefetch(address);
#endif
}

}  // namespace clbvh
