#include "io/output_file.hpp"

#include <array>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <random>
#include <string>
#include <system_error>

#include "clbvh/core/error.hpp"

namespace clbvh::io {
namespace {

std::filesystem::path temporary_name() {
    std::random_device random;
    const std::uint64_t number = (std::uint64_t{random()} << 32) | random();
    std::array<char, 16> digits{};
    const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), number, 16);
    return ".clbvh-" + std::string(digits.data(), end) + ".tmp";
}

}  // namespace

OutputFile::OutputFile(const std::filesystem::path& path) : target_(path) {
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(path, error);
    if (std::filesystem::is_directory(status)) fail(EISDIR);
    if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
        file_.reset(std::fopen(target_.c_str(), "wb"));
    } else {
        // A rename would replace a link, not the file that it points to.
        if (std::filesystem::is_symlink(std::filesystem::symlink_status(path, error))) {
            const std::filesystem::path linked = std::filesystem::canonical(path, error);
            if (error) fail(error.value());
            target_ = linked;
        }
        temporary_ = target_.parent_path() / temporary_name();
        file_.reset(std::fopen(temporary_.c_str(), "wbx"));
    }
    if (!file_) fail(errno);
}

OutputFile::~OutputFile() {
    if (temporary_.empty()) return;
    file_.reset();
    std::error_code ignored;
    std::filesystem::remove(temporary_, ignored);
}

void OutputFile::write(const void* from, std::size_t bytes) {
    if (bytes > 0 && std::fwrite(from, 1, bytes, file_.get()) != bytes) fail(errno);
}

void OutputFile::commit() {
    // Closing flushes what is buffered, so this is where a full disk may first show.
    if (std::fclose(file_.release()) != 0) fail(errno);
    if (temporary_.empty()) return;
    std::error_code error;
    std::filesystem::rename(temporary_, target_, error);
    if (error) fail(error.value());
    temporary_.clear();
}

void OutputFile::fail(int error) const {
    throw Error(ErrorCode::io, "cannot write " + target_.string() + ": " + std::generic_category().message(error));
}

}  // namespace clbvh::io
