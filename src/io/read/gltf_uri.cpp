#include "io/read/gltf_uri.hpp"

#include <algorithm>
#include <cstdint>
#include <system_error>

namespace clbvh::io {
namespace {

int value_of_base64(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    if (c == '+' || c == '-') return 62;  // the second is that of URLs
    if (c == '/' || c == '_') return 63;
    return -1;
}

int value_of_hex(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

std::optional<std::string> decode_base64(std::string_view text) {
    while (text.ends_with('='))
        text.remove_suffix(1);
    if (text.size() % 4 == 1) return std::nullopt;
    std::string bytes;
    bytes.reserve(text.size() / 4 * 3 + 2);
    std::uint32_t bits = 0;
    int count = 0;
    for (const char c : text) {
        const int value = value_of_base64(c);
        if (value < 0) return std::nullopt;
        bits = bits << 6U | static_cast<std::uint32_t>(value);
        count += 6;
        if (count < 8) continue;
        count -= 8;
        bytes.push_back(static_cast<char>(bits >> count & 0xFFU));
    }
    return bytes;
}

std::string decode_percent(std::string_view text) {
    std::string result;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '%' && i + 2 < text.size() && value_of_hex(text[i + 1]) >= 0 && value_of_hex(text[i + 2]) >= 0) {
            result.push_back(static_cast<char>(value_of_hex(text[i + 1]) * 16 + value_of_hex(text[i + 2])));
            i += 2;
        } else {
            result.push_back(text[i]);
        }
    }
    return result;
}

}  // namespace

std::optional<std::string> decode_data_uri(std::string_view uri) {
    if (!uri.starts_with("data:")) return std::nullopt;
    const std::size_t comma = uri.find(',');
    if (comma == std::string_view::npos || !uri.substr(0, comma).ends_with(";base64")) return std::nullopt;
    return decode_base64(uri.substr(comma + 1));
}

std::optional<std::filesystem::path> relative_path_of(std::string_view uri) {
    const std::size_t colon = uri.find(':');
    if (colon != std::string_view::npos && colon < uri.find('/')) return std::nullopt;
    const std::string decoded = decode_percent(uri);
    if (decoded.empty() || decoded.find('\0') != std::string::npos) return std::nullopt;
    const std::filesystem::path path = std::filesystem::path(decoded).lexically_normal();
    if (path.is_absolute() || path.empty() || *path.begin() == "..") return std::nullopt;
    return path;
}

bool lies_below(const std::filesystem::path& path, const std::filesystem::path& folder) {
    std::error_code error;
    const std::filesystem::path outer = std::filesystem::weakly_canonical(folder.empty() ? "." : folder, error);
    if (error) return false;
    const std::filesystem::path inner = std::filesystem::weakly_canonical(outer / path, error);
    return !error && std::ranges::mismatch(outer, inner).in1 == outer.end();
}

}  // namespace clbvh::io
