#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace clbvh::tool {

/// Throws Error(io) where no regular file can be made at `path`, so that a typing error is found before the long work.
void require_writable(const std::filesystem::path& path);

/// Writes under a temporary name beside `path` and renames it, so that `path` is never half-written.
/// Throws Error(io) naming the path and the system's reason.
void write_file(const std::filesystem::path& path, std::string_view text);

/// The same for what a user gave as the target: "-" is standard output, and pipes and devices such as /dev/stderr,
/// which a rename would replace, are written to as they are.
void require_writable_target(const std::string& target);
void write_target(const std::string& target, std::string_view text);

}  // namespace clbvh::tool
