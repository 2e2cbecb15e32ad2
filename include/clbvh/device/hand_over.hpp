#pragma once

#include <cstdint>
#include <string_view>

namespace clbvh {

/// How work groups of a device tell each other things, as in climbs from the leaves of a tree to its root. The trees
/// are the same.
enum class HandOver : std::uint8_t {
    automatic,         ///< within_launch on CPU devices, and on others that pass a self-test; else between_launches.
    within_launch,     ///< Through memory, in order by fences that reach the whole device.
    between_launches,  ///< By the end of a launch alone, or within one work group. Slower; for devices whose fences
                       ///< fail.
};

/// "auto", "within", "between"; empty for what is no enumerator.
[[nodiscard]] constexpr std::string_view to_string(HandOver hand_over) noexcept {
    switch (hand_over) {
        case HandOver::automatic: return "auto";
        case HandOver::within_launch: return "within";
        case HandOver::between_launches: return "between";
    }
    return {};
}

}  // namespace clbvh
