#pragma once

#include <cstdint>
#include <span>

#include "host/build/radix_sort.hpp"
#include "host/build/reference.hpp"

namespace clbvh::host {

/// Where more than a few primitives share one code, as around a far triangle, each such run gets codes within its own
/// bounds, and again until none is left, the bits are spent, or all that is left of a run is in one place. `sorted` has
/// ascending codes, and the places in `references` that they belong to; so it has afterwards. Codes of a scene without
/// such runs stay as they are. Bits that decide neither the order nor the tree over it make room for the new ones.
/// Throws std::bad_alloc.
void refine_codes(const KeyedValues<std::uint64_t>& sorted, std::span<const Reference> references);

}  // namespace clbvh::host
