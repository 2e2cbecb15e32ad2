#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace clbvh::io {

enum class PlyFormat : std::uint8_t { ascii, binary_little_endian, binary_big_endian };

enum class PlyType : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

[[nodiscard]] constexpr bool is_integer(PlyType type) noexcept {
    return type < PlyType::float32;
}

/// Bytes of a binary value.
[[nodiscard]] constexpr std::size_t size_of(PlyType type) noexcept {
    switch (type) {
        case PlyType::int8:
        case PlyType::uint8: return 1;
        case PlyType::int16:
        case PlyType::uint16: return 2;
        case PlyType::int32:
        case PlyType::uint32:
        case PlyType::float32: return 4;
        case PlyType::float64: return 8;
    }
    return 0;
}

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::float32;      ///< Of the value, or of a list's entries.
    bool is_list = false;                 ///< A count, then as many entries.
    PlyType count_type = PlyType::uint8;  ///< Of a list's count; an integer type.
};

struct PlyElement {
    std::string name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties;  ///< At least one.
};

struct PlyHeader {
    PlyFormat format = PlyFormat::ascii;
    std::vector<PlyElement> elements;  ///< No two of the same name.
    std::size_t body = 0;              ///< Where the first element's data begins.
};

/// Parses the header at the front of a PLY file. Comments may stand anywhere behind the first line. Throws Error(io)
/// with the name and the header's line.
[[nodiscard]] PlyHeader parse_ply_header(std::string_view file, const std::string& name);

}  // namespace clbvh::io
