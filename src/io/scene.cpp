#include "clbvh/io/scene.hpp"

#include <charconv>
#include <new>
#include <string>
#include <system_error>
#include <vector>

#include "clbvh/core/error.hpp"
#include "io/assimp_import.hpp"
#include "io/input_file.hpp"
#include "io/obj.hpp"
#include "io/ply.hpp"

namespace clbvh {
namespace {

constexpr std::string_view kGeneratorPrefix = "gen:";

std::vector<std::string_view> split(std::string_view text, char separator) {
    std::vector<std::string_view> fields;
    while (true) {
        const std::size_t end = text.find(separator);
        fields.push_back(text.substr(0, end));
        if (end == std::string_view::npos) return fields;
        text.remove_prefix(end + 1);
    }
}

std::uint64_t parse_number(std::string_view text, const std::string& what, std::string_view scene) {
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    const bool whole = end == text.data() + text.size();
    if (error == std::errc{} && whole) return number;
    const bool large = error == std::errc::result_out_of_range && whole;
    throw Error(ErrorCode::invalid_input, std::string(scene) + ": the " + what + " \"" + std::string(text) + "\" is " +
                                              (large ? "too large" : "not a whole number"));
}

Mesh generate_from(std::string_view scene) {
    const std::vector<std::string_view> fields = split(scene.substr(kGeneratorPrefix.size()), ':');
    if (fields.size() > 3) {
        throw Error(ErrorCode::invalid_input, std::string(scene) + ": expected gen:NAME[:COUNT[:SEED]]");
    }
    const std::uint64_t count = fields.size() > 1 ? parse_number(fields[1], "count", scene) : kDefaultSceneTriangles;
    const std::uint64_t seed = fields.size() > 2 ? parse_number(fields[2], "seed", scene) : 1;
    return generate_scene(fields[0], count, seed);
}

Mesh load_file(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    for (char& c : extension) {
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    }
    if (extension == ".obj") return io::load_obj(path);
    if (extension == ".ply") return io::load_ply(path);
    // A file that cannot be opened is reported as such, whatever its format.
    (void)io::InputFile(path);
    return io::load_with_assimp(path);
}

}  // namespace

Mesh load_scene(std::string_view scene) try {
    return scene.starts_with(kGeneratorPrefix) ? generate_from(scene) : load_file(scene);
} catch (const std::bad_alloc&) {
    throw Error(ErrorCode::out_of_memory, std::string(scene) + ": not enough memory for the scene");
}

}  // namespace clbvh
