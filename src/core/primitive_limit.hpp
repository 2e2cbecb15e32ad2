#pragma once

#include <cstdint>

namespace clbvh {

/// Throws Error(unsupported) where `count` is more than kMaxPrimitives.
void check_primitive_count(std::uint64_t count);

}  // namespace clbvh
