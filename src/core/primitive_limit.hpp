#pragma once

#include <cstdint>
#include <string_view>

namespace clbvh {

/// Throws Error(unsupported) where `count` is more than kMaxPrimitives. `what` is what there are so many of.
void check_primitive_count(std::uint64_t count, std::string_view what);

}  // namespace clbvh
