#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace clbvh {

/// FNV-1a in 64 bits (Fowler, Noll, Vo): tells apart what accidents change, not what an attacker does.
[[nodiscard]] constexpr std::uint64_t fnv1a(std::string_view bytes, std::uint64_t hash = 0xcbf29ce484222325u) {
    for (const char byte : bytes) {
        hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3u;
    }
    return hash;
}

/// 16 digits.
[[nodiscard]] inline std::string hexadecimal(std::uint64_t number) {
    std::string digits;
    for (int shift = 60; shift >= 0; shift -= 4)
        digits += "0123456789abcdef"[number >> shift & 15];
    return digits;
}

}  // namespace clbvh
