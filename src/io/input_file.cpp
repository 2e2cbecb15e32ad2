#include "io/input_file.hpp"

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "clbvh/core/error.hpp"

namespace clbvh::io {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& reason) {
    throw Error(ErrorCode::io, "cannot read " + path.string() + ": " + reason);
}

std::string reason_of(int error) {
    return std::generic_category().message(error);
}

}  // namespace

InputFile::InputFile(const std::filesystem::path& path) : path_(path) {
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(path, error);
    if (std::filesystem::is_directory(status)) fail(path, reason_of(EISDIR));
    // Opening a pipe would wait for its writer.
    if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) fail(path, "not a regular file");

    file_.reset(std::fopen(path.c_str(), "rb"));
    if (!file_) fail(path, reason_of(errno));
    size_ = std::filesystem::file_size(path, error);
    if (error) fail(path, error.message());
}

void InputFile::read(void* to, std::size_t bytes) {
    if (bytes == 0) return;
    errno = 0;
    if (std::fread(to, 1, bytes, file_.get()) == bytes) return;
    fail(path_, std::ferror(file_.get()) != 0 ? reason_of(errno) : "the file ends early");
}

std::string read_whole_file(const std::filesystem::path& path, const std::function<void()>& tick) {
    constexpr std::size_t kBytesPerTick = std::size_t{1} << 22U;
    InputFile file(path);
    std::string content(file.size(), '\0');
    for (std::size_t place = 0; place < content.size(); place += kBytesPerTick) {
        tick();
        file.read(content.data() + place, std::min(kBytesPerTick, content.size() - place));
    }
    return content;
}

}  // namespace clbvh::io
