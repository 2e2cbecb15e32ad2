#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

// URIs of glTF buffers.
namespace clbvh::io {

/// The bytes of a "data:...;base64,..." URI; nothing where it is none, or its base64 is broken.
[[nodiscard]] std::optional<std::string> decode_data_uri(std::string_view uri);

/// The path below a folder that a relative URI names, its %20 and the like decoded. Nothing where it has a scheme, is
/// absolute, leaves the folder, or holds a zero byte.
[[nodiscard]] std::optional<std::filesystem::path> relative_path_of(std::string_view uri);

/// Whether that path, with all symbolic links followed, lies below the folder.
[[nodiscard]] bool lies_below(const std::filesystem::path& path, const std::filesystem::path& folder);

}  // namespace clbvh::io
