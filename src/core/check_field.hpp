#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace clbvh {

inline constexpr std::uint32_t kMaxLeafSize = 64;
inline constexpr std::uint32_t kMaxBinCount = 64;
inline constexpr std::uint32_t kMaxPresplitLevel = 40;
inline constexpr float kMaxSplitQuota = 4.0f;

/// Throws Error(invalid_input): "FIELD is VALUE; it must be RANGE".
[[noreturn]] void reject_field(std::string_view field, const std::string& value, std::string_view range);

/// Throws as reject_field does where `value` is not in least .. most; a NaN is in no range.
void check_range(std::string_view field, std::uint32_t value, std::uint32_t least, std::uint32_t most);
void check_range(std::string_view field, float value, float least, float most);

/// Throws as reject_field does where `value` is not finite and above 0.
void check_positive(std::string_view field, float value);

}  // namespace clbvh
