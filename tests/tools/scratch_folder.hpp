#pragma once

#include <filesystem>
#include <string>

namespace clbvh::test {

/// An empty folder of its own, deleted with everything in it at the end.
class ScratchFolder {
public:
    ScratchFolder();
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;
    ~ScratchFolder();

    /// The path of `name` inside the folder.
    [[nodiscard]] std::string path(const std::string& name) const;
    /// How many files are in it.
    [[nodiscard]] std::size_t file_count() const;

private:
    std::filesystem::path folder_;
};

/// The whole content of a file.
[[nodiscard]] std::string read_text(const std::filesystem::path& path);

}  // namespace clbvh::test
