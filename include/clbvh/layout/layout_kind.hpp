#pragma once

#include <cstdint>
#include <string_view>

namespace clbvh {

/// The layouts, as numbered in files.
enum class LayoutKind : std::uint32_t { wide8 = 1, wide4 = 2, compressed8 = 3, pair = 4, skip = 5 };

/// "wide8", "wide4", "compressed8", "pair", "skip"; empty for what is no enumerator.
[[nodiscard]] constexpr std::string_view to_string(LayoutKind kind) noexcept {
    switch (kind) {
        case LayoutKind::wide8: return "wide8";
        case LayoutKind::wide4: return "wide4";
        case LayoutKind::compressed8: return "compressed8";
        case LayoutKind::pair: return "pair";
        case LayoutKind::skip: return "skip";
    }
    return {};
}

}  // namespace clbvh
