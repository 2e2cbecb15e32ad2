#include "cli/scene_check.hpp"

#include <cerrno>
#include <clbvh/core/error.hpp>
#include <clbvh/io/scene.hpp>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace clbvh::tool {
namespace {

namespace fs = std::filesystem;

void require_file(const std::string& path) {
    const auto fail = [&path](const std::string& reason) {
        throw Error(ErrorCode::io, "cannot read " + path + ": " + reason);
    };
    std::error_code ignored;
    const fs::file_status status = fs::status(path, ignored);
    if (fs::is_directory(status)) fail(std::generic_category().message(EISDIR));
    // Opening a pipe would wait for its writer.
    if (fs::exists(status) && !fs::is_regular_file(status)) fail("not a regular file");
    if (!std::ifstream(path)) fail(std::generic_category().message(errno));
}

}  // namespace

void require_scene(const std::string& scene) {
    if (is_generated_scene(scene)) {
        static_cast<void>(parse_generated_scene(scene));
    } else {
        require_file(scene);
    }
}

}  // namespace clbvh::tool
