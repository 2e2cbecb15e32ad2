#pragma once

#include <cstddef>
#include <filesystem>

#include "io/input_file.hpp"

namespace clbvh::io {

/// A file that appears under its name only when it is complete: what is written goes to a temporary name in the same
/// folder, and commit() renames it. Without a commit nothing is left behind. Every failure is an Error(io) that names
/// the target and the system's reason.
///
/// A target that exists and is no regular file (/dev/null, a pipe) is written directly: a rename would replace it.
class OutputFile {
public:
    explicit OutputFile(const std::filesystem::path& path);
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;
    ~OutputFile();

    void write(const void* from, std::size_t bytes);
    void commit();

private:
    [[noreturn]] void fail(int error) const;

    std::filesystem::path target_;
    std::filesystem::path temporary_;  // empty where the target is written directly
    FileHandle file_;
};

}  // namespace clbvh::io
