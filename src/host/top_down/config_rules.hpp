#pragma once

#include "core/check_field.hpp"

namespace clbvh::host {

inline constexpr std::uint32_t kMaxBinCount = 64;

// Ranges of the fields of BinnedSahConfig and SbvhConfig.
inline constexpr WholeRule kBinCounts{.least = 2, .most = kMaxBinCount};
inline constexpr RealRule kSplitAlphas{.least = 0.0f, .most = 1.0f};
inline constexpr RealRule kSplitOverlaps{.least = 0.0f, .most = 1.0f};
inline constexpr RealRule kReferenceBudgets{.least = 1.0f, .most = 8.0f};

}  // namespace clbvh::host
