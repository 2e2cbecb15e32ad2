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

/// A path of this name where nothing is, in a folder of the tests' own that stays empty.
[[nodiscard]] std::string missing_path(const std::string& name);

/// The variable by which OpenCL's loader finds no driver.
[[nodiscard]] std::string no_drivers();

/// The whole content of a file.
[[nodiscard]] std::string read_text(const std::filesystem::path& path);

}  // namespace clbvh::test
