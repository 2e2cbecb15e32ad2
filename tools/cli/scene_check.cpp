#include "cli/scene_check.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <clbvh/core/error.hpp>
#include <clbvh/core/mesh.hpp>
#include <clbvh/io/scene.hpp>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>

namespace clbvh::tool {
namespace {

namespace fs = std::filesystem;

/// Takes the text up to the next colon, and the colon, off `rest`.
std::string_view take_field(std::string_view& rest) {
    const std::size_t end = std::min(rest.find(':'), rest.size());
    const std::string_view field = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    return field;
}

bool is_number_up_to(std::uint64_t most, std::string_view text) {
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc{} && end == text.data() + text.size() && number <= most;
}

/// True where `words`, what follows "gen:", is NAME[:COUNT[:SEED]] beyond doubt.
bool is_generated(std::string_view words) {
    if (words.ends_with(':')) return false;
    const std::string_view name = take_field(words);
    const auto generators = scene_generators();
    if (std::ranges::find(generators, name, &SceneGeneratorInfo::name) == generators.end()) return false;
    if (!words.empty() && !is_number_up_to(kMaxPrimitives, take_field(words))) return false;
    return words.empty() || is_number_up_to(UINT64_MAX, words);
}

/// The library says what is wrong with the scene, before it generates anything, but not always which scene it was.
void refuse_generated(const std::string& scene) try {
    static_cast<void>(load_scene(scene));
} catch (const Error& error) {
    if (std::string_view(error.what()).starts_with(scene)) throw;
    throw Error(error.code(), scene + ": " + error.what());
}

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
    constexpr std::string_view prefix = "gen:";
    if (!scene.starts_with(prefix)) {
        require_file(scene);
    } else if (!is_generated(std::string_view(scene).substr(prefix.size()))) {
        refuse_generated(scene);
    }
}

}  // namespace clbvh::tool
