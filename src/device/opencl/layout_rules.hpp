#pragma once

#include "core/check_field.hpp"

namespace clbvh::device {

// Options that lay work out, and may come from a device's profile as well: PlocConfig's.
inline constexpr WholeRule kChunkSizes{.least = 64, .most = 4096, .step = 64, .or_chosen = true};
inline constexpr WholeRule kWorkGroupSizes{.least = 32, .most = 1024, .powers_of_two = true, .or_chosen = true};
inline constexpr WholeRule kSingleGroupThresholds{.least = 2, .most = 1u << 20, .or_chosen = true};

}  // namespace clbvh::device
