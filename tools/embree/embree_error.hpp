#pragma once

#include <embree3/rtcore.h>

#include <string_view>

namespace clbvh::tool {

/// The enumerator's name, for example "RTC_ERROR_INVALID_ARGUMENT".
[[nodiscard]] std::string_view embree_error_name(RTCError error) noexcept;

}  // namespace clbvh::tool
