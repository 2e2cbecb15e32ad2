#include "device/opencl/kernel_dump.hpp"

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "clbvh/core/error.hpp"
#include "core/fnv1a.hpp"
#include "device/opencl/user_folder.hpp"

namespace clbvh::device {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const std::string& reason) {
    throw Error(ErrorCode::io, "CLBVH_DUMP_KERNELS: cannot write " + path.string() + ": " + reason);
}

}  // namespace

void dump_kernels(std::string_view files, const std::string& options, const std::string& source) {
    const fs::path folder = environment("CLBVH_DUMP_KERNELS");
    if (folder.empty()) return;
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) fail(folder, error.message());
    const fs::path first = fs::path(files.substr(0, files.find(','))).stem();
    const fs::path path = folder / (first.string() + "-" + hexadecimal(fnv1a(source, fnv1a(options))) + ".cl");
    errno = 0;
    std::ofstream file(path, std::ios::binary);
    file << "// " << files << "\n// options: " << options << '\n' << source;
    file.close();
    if (!file) fail(path, std::generic_category().message(errno != 0 ? errno : EIO));
}

}  // namespace clbvh::device
