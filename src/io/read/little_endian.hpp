#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace clbvh::io {

/// The 32 bits at a place of binary data that is little-endian.
[[nodiscard]] inline std::uint32_t little_endian_word(std::string_view bytes, std::size_t at) noexcept {
    const auto byte = [&](std::size_t i) { return std::uint32_t{static_cast<unsigned char>(bytes[at + i])}; };
    return byte(0) | byte(1) << 8U | byte(2) << 16U | byte(3) << 24U;
}

}  // namespace clbvh::io
