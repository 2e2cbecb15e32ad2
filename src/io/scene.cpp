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
#include "io/scene_generator.hpp"

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

bool is_generated_scene(std::string_view scene) noexcept {
    return scene.starts_with(kGeneratorPrefix);
}

GeneratedScene parse_generated_scene(std::string_view scene) {
    std::vector<std::string_view> fields = split(scene.substr(kGeneratorPrefix.size()), ':');
    GeneratedScene generated{std::string(fields[0]), {}, {}};
    const auto fail = [&](const std::string& why) {
        throw Error(ErrorCode::invalid_input, std::string(scene) + ": " + why);
    };
    const std::string parameter = io::standard_parameter(fields[0]);
    const bool takes_parameter = !parameter.empty();
    if (takes_parameter) {
        generated.name += ":" + (fields.size() > 1 ? std::string(fields[1]) : parameter);
        if (fields.size() > 1) fields.erase(fields.begin() + 1);
    }
    if (fields.size() > 3) {
        fail(takes_parameter ? "expected gen:NAME[:PARAMETER[:COUNT[:SEED]]]" : "expected gen:NAME[:COUNT[:SEED]]");
    }
    if (fields.size() > 1) generated.count = parse_number(fields[1], "count", scene);
    if (fields.size() > 2) generated.seed = parse_number(fields[2], "seed", scene);
    const std::string wrong = io::fault_of_scene(generated.name, generated.count.value_or(0));
    if (!wrong.empty()) fail(wrong);
    return generated;
}

Mesh load_scene(std::string_view scene) try {
    if (!is_generated_scene(scene)) return load_file(scene);
    const GeneratedScene generated = parse_generated_scene(scene);
    return generate_scene(generated.name, generated.count.value_or(kDefaultSceneTriangles), generated.seed.value_or(1));
} catch (const std::bad_alloc&) {
    throw Error(ErrorCode::out_of_memory, std::string(scene) + ": not enough memory for the scene");
}

}  // namespace clbvh
