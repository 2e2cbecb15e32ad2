#include "cli/output_file.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <clbvh/core/error.hpp>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <memory>
#include <random>
#include <string>
#include <system_error>

namespace clbvh::tool {
namespace {

namespace fs = std::filesystem;

struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Close>;

[[noreturn]] void fail(const fs::path& path, int reason) {
    throw Error(ErrorCode::io,
                fmt::format("cannot write '{}': {}", path.string(), std::generic_category().message(reason)));
}

/// Beside the file, in a name that nobody else can know before, and that is short however long the file's is.
fs::path temporary_name(const fs::path& path) {
    std::random_device random;
    return path.parent_path() / fmt::format(".clbvh-{:08x}{:08x}.tmp", random(), random());
}

void write_to_stream(std::ostream& stream, std::string_view text, const std::string& name) {
    if (!(stream << text << std::flush)) fail(name, errno);
}

bool is_special(const std::string& target) {
    std::error_code ignored;
    const fs::file_status status = fs::status(target, ignored);
    return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

File open_for_writing(const fs::path& temporary, const fs::path& path) {
    File file(std::fopen(temporary.c_str(), "wbx"));
    if (!file) fail(path, errno);
    return file;
}

}  // namespace

void require_writable(const fs::path& path) {
    std::error_code error, ignored;
    const fs::file_status status = fs::status(path, error);
    if (error == std::errc::filename_too_long) fail(path, error.value());
    if (fs::exists(status) && !fs::is_regular_file(status)) {
        throw Error(ErrorCode::io,
                    fmt::format("cannot write '{}': it exists and is not a regular file", path.string()));
    }
    const fs::path temporary = temporary_name(path);
    open_for_writing(temporary, path);
    fs::remove(temporary, ignored);
}

void write_file(const fs::path& path, std::string_view text) {
    const fs::path temporary = temporary_name(path);
    File file = open_for_writing(temporary, path);
    bool written = std::fwrite(text.data(), 1, text.size(), file.get()) == text.size();
    written = std::fclose(file.release()) == 0 && written;
    if (!written || std::rename(temporary.c_str(), path.c_str()) != 0) {
        const int reason = errno;
        std::error_code ignored;
        fs::remove(temporary, ignored);
        fail(path, reason);
    }
}

void require_writable_target(const std::string& target) {
    if (target != "-" && !is_special(target)) require_writable(target);
}

void write_target(const std::string& target, std::string_view text) {
    if (target == "-") {
        write_to_stream(std::cout, text, "standard output");
    } else if (is_special(target)) {
        std::ofstream stream(target);
        write_to_stream(stream, text, target);
    } else {
        write_file(target, text);
    }
}

}  // namespace clbvh::tool
