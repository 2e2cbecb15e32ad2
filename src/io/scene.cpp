#include "clbvh/io/scene.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <iterator>
#include <new>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "clbvh/core/error.hpp"
#include "io/input_file.hpp"
#include "io/read/assimp_import.hpp"
#include "io/read/gltf.hpp"
#include "io/read/obj.hpp"
#include "io/read/off.hpp"
#include "io/read/ply.hpp"
#include "io/read/stl.hpp"
#include "io/read/words.hpp"
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

/// The readers of this library. Each takes a whole file.
using Reader = void (*)(std::string_view text, const std::filesystem::path& path, io::MeshSink& sink);

template <void (*Read)(std::string_view, io::MeshSink&)>
constexpr Reader kAlone =
    [](std::string_view text, const std::filesystem::path&, io::MeshSink& sink) { Read(text, sink); };

void read_gltf_beside(std::string_view text, const std::filesystem::path& path, io::MeshSink& sink) {
    io::read_gltf(text, path.parent_path(), sink);
}

constexpr std::pair<std::string_view, Reader> kReaders[] = {
    {".obj", kAlone<io::read_obj>}, {".ply", kAlone<io::read_ply>}, {".stl", kAlone<io::read_stl>},
    {".off", kAlone<io::read_off>}, {".gltf", read_gltf_beside},    {".glb", read_gltf_beside},
};

Mesh load_file(const std::filesystem::path& path, const LoadOptions& options) {
    std::string extension = path.extension().string();
    std::ranges::transform(extension, extension.begin(), io::lower_case);
    const auto* const reader =
        std::ranges::find(kReaders, std::string_view(extension), &std::pair<std::string_view, Reader>::first);
    std::string text;
    if (reader != std::end(kReaders)) {
        text = io::read_whole_file(path, [&] {
            if (options.progress && !options.progress({"load", 0.0}))
                throw Error(ErrorCode::cancelled, path.string() + ": loading was cancelled");
        });
    } else {
        // A file that cannot be opened is reported as such, whatever its format.
        (void)io::InputFile(path);
    }
    io::MeshSink sink(path.string(), text.size(), options.progress);
    if (options.max_bytes != 0) sink.max_bytes = options.max_bytes;
    reader != std::end(kReaders) ? reader->second(text, path, sink) : io::read_with_assimp(path, sink);
    if (options.report != nullptr) *options.report = sink.report;
    return std::move(sink.mesh);
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

Mesh load_scene(std::string_view scene, const LoadOptions& options) try {
    if (!is_generated_scene(scene)) return load_file(scene, options);
    const GeneratedScene generated = parse_generated_scene(scene);
    Mesh mesh =
        generate_scene(generated.name, generated.count.value_or(kDefaultSceneTriangles), generated.seed.value_or(1));
    if (options.report != nullptr) {
        *options.report = {};
        options.report->faces = mesh.triangles.size();
    }
    return mesh;
} catch (const std::bad_alloc&) {
    throw Error(ErrorCode::out_of_memory, std::string(scene) + ": not enough memory for the scene");
}

}  // namespace clbvh
