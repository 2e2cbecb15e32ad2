#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

namespace clbvh::io {

struct FileCloser {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
};
using FileHandle = std::unique_ptr<std::FILE, FileCloser>;

/// A regular file, open for reading from front to back. Every failure is an Error(io) that names the file and the
/// system's reason.
class InputFile {
public:
    explicit InputFile(const std::filesystem::path& path);

    [[nodiscard]] std::uint64_t size() const noexcept { return size_; }
    /// Reads exactly `bytes` bytes.
    void read(void* to, std::size_t bytes);

private:
    std::filesystem::path path_;
    FileHandle file_;
    std::uint64_t size_ = 0;
};

/// The whole content of a file. Throws what InputFile throws, and what `tick` does, which is called every few MiB.
[[nodiscard]] std::string read_whole_file(
    const std::filesystem::path& path, const std::function<void()>& tick = [] {});

}  // namespace clbvh::io
