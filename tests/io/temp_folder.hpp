#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace clbvh::test {

/// An empty folder for one test, removed with everything in it at the end.
class TempFolder {
public:
    TempFolder();
    TempFolder(const TempFolder&) = delete;
    TempFolder& operator=(const TempFolder&) = delete;
    ~TempFolder();

    [[nodiscard]] std::filesystem::path path(std::string_view name) const { return folder_ / name; }
    [[nodiscard]] std::size_t entry_count() const;
    /// Makes a file, and returns its path.
    [[nodiscard]] std::string write(std::string_view name, std::string_view content) const;

private:
    std::filesystem::path folder_;
};

/// The whole content of a file.
[[nodiscard]] std::string content_of(const std::filesystem::path& path);

}  // namespace clbvh::test
