#pragma once

#include <cstdint>

namespace clbvh::host {

inline constexpr std::uint32_t kMaxPresplitLevel = 40;  ///< PresplitConfig::level
inline constexpr float kMaxSplitQuota = 4.0f;           ///< of split_to_quota

}  // namespace clbvh::host
