#include "io/read/gltf_document.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "clbvh/core/error.hpp"
#include "io/input_file.hpp"
#include "io/read/gltf_uri.hpp"
#include "io/read/little_endian.hpp"
#include "io/read/words.hpp"

namespace clbvh::io {
namespace {

constexpr int kMostDepth = 100;  // of JSON within JSON: a file that is deeper is none of glTF

/// What a file may require because it changes no triangle, or because it is read here.
bool is_known(std::string_view extension) {
    constexpr std::array<std::string_view, 4> kKnown{"KHR_mesh_quantization", "EXT_mesh_gpu_instancing",
                                                     "KHR_lights_punctual", "KHR_xmp_json_ld"};
    constexpr std::array<std::string_view, 4> kOfSurfaces{"KHR_materials_", "KHR_texture_", "EXT_texture_",
                                                          "EXT_materials_"};
    return std::ranges::find(kKnown, extension) != kKnown.end() ||
           std::ranges::any_of(kOfSurfaces, [&](std::string_view start) { return extension.starts_with(start); });
}

}  // namespace

std::string gltf_place(const char* array, std::uint64_t index) {
    return std::string(array) + '[' + std::to_string(index) + ']';
}

GltfDocument::GltfDocument(std::string_view text, const std::filesystem::path& folder, MeshSink& sink) : sink_(sink) {
    constexpr std::size_t kHeaderBytes = 12, kChunkBytes = 8;
    constexpr std::uint32_t kJsonChunk = 0x4E4F534AU, kBinaryChunk = 0x004E4942U;
    if (!text.starts_with("glTF")) {
        parse(without_byte_order_mark(text));
    } else {
        if (text.size() < kHeaderBytes + kChunkBytes) fail("the header", "the file ends early");
        if (const std::uint32_t version = little_endian_word(text, 4); version != 2)
            fail("the header", "version " + std::to_string(version) + " of GLB; only 2 is read");
        if (little_endian_word(text, 8) > text.size()) {
            fail("the header", "it promises " + std::to_string(little_endian_word(text, 8)) +
                                   " bytes, but the file has " + std::to_string(text.size()) + ": is it truncated?");
        }
        for (std::size_t place = kHeaderBytes; place + kChunkBytes <= text.size();) {
            const std::size_t bytes = little_endian_word(text, place);
            const std::uint32_t type = little_endian_word(text, place + 4);
            const std::string name = "the chunk at byte " + std::to_string(place);
            place += kChunkBytes;
            if (bytes > text.size() - place) fail(name, "it ends behind the file");
            if (json_.is_null() && type != kJsonChunk) fail(name, "the first one must be of JSON");
            if (json_.is_null()) parse(text.substr(place, bytes));
            if (type == kBinaryChunk && binary_.empty()) binary_ = text.substr(place, bytes);
            place += bytes + (4 - bytes % 4) % 4;
        }
    }
    check_version_and_extensions();
    load_buffers(folder);
}

void GltfDocument::parse(std::string_view json) {
    const auto check_depth = [this](int depth, Json::parse_event_t, Json&) {
        if (depth > kMostDepth) fail("the JSON", "it is nested more than " + std::to_string(kMostDepth) + " deep");
        sink_.tick_item();
        return true;
    };
    try {
        json_ = Json::parse(json, check_depth);
    } catch (const Json::exception& error) {
        fail("the JSON", error.what());
    }
    if (!json_.is_object()) fail("the JSON", "not a glTF file: it is no object");
}

void GltfDocument::check_version_and_extensions() const {
    const Json* const asset = find(json_, "asset", Json::value_t::object, "the file");
    if (asset == nullptr) fail("the file", "not a glTF file: \"asset\" is missing");
    const Json* const version = find(*asset, "version", Json::value_t::string, "asset");
    if (version == nullptr || !version->get_ref<const std::string&>().starts_with("2."))
        fail("asset.version", "only glTF 2 is read");
    const Json* const required = find(json_, "extensionsRequired", Json::value_t::array, "the file");
    if (required == nullptr) return;
    for (const Json& extension : *required) {
        if (!extension.is_string()) fail("extensionsRequired", "an element is no string");
        const std::string& name = extension.get_ref<const std::string&>();
        if (is_known(name)) continue;
        throw Error(ErrorCode::unsupported,
                    sink_.name() + ": it requires the extension " + quote(name) + ", which is not read");
    }
}

const GltfDocument::Json* GltfDocument::find(const Json& object, const char* name, Json::value_t type,
                                             const std::string& place) const {
    const auto found = object.find(name);
    if (found == object.end()) return nullptr;
    if (found->type() != type) {
        fail(place + '.' + name,
             std::string("it is of type ") + found->type_name() + ", not " + Json(type).type_name());
    }
    return &*found;
}

const GltfDocument::Json& GltfDocument::element(const char* name, std::uint64_t index, const std::string& from) const {
    const std::size_t size = count(name);
    if (index >= size) {
        fail(from, gltf_place(name, index) + " does not exist; the file has " + std::to_string(size));
    }
    const Json& result = json_[name][index];
    if (!result.is_object()) fail(gltf_place(name, index), "it is no object");
    return result;
}

std::size_t GltfDocument::count(const char* name) const {
    const Json* const array = find(json_, name, Json::value_t::array, "the file");
    return array != nullptr ? array->size() : 0;
}

std::uint64_t GltfDocument::whole(const Json& object, const char* name, const std::string& place,
                                  std::optional<std::uint64_t> missing) const {
    const auto found = object.find(name);
    if (found == object.end()) {
        if (!missing) fail(place, std::string("\"") + name + "\" is missing");
        return *missing;
    }
    if (found->is_number_unsigned()) return found->get<std::uint64_t>();
    // Some exporters write 3.0.
    constexpr double kMost = 9007199254740992.0;
    if (found->is_number_float()) {
        const auto value = found->get<double>();
        if (value >= 0.0 && value <= kMost && value == std::floor(value)) return static_cast<std::uint64_t>(value);
    }
    fail(place + '.' + name, found->dump().substr(0, 40) + " is no whole number of at least 0");
}

std::vector<double> GltfDocument::numbers(const Json& object, const char* name, std::size_t size,
                                          const std::string& place) const {
    const Json* const array = find(object, name, Json::value_t::array, place);
    if (array == nullptr) return {};
    if (array->size() != size) {
        fail(place + '.' + name, "it has " + std::to_string(array->size()) + " elements, not " + std::to_string(size));
    }
    std::vector<double> result;
    for (const Json& value : *array) {
        if (!value.is_number()) fail(place + '.' + name, "an element is no number");
        result.push_back(value.get<double>());
    }
    return result;
}

void GltfDocument::load_buffers(const std::filesystem::path& folder) {
    const std::size_t buffers = count("buffers");
    for (std::size_t i = 0; i < buffers; ++i) {
        const std::string place = gltf_place("buffers", i);
        const Json& buffer = element("buffers", i, "buffers");
        const std::uint64_t size = whole(buffer, "byteLength", place);
        const Json* const uri = find(buffer, "uri", Json::value_t::string, place);
        if (uri != nullptr) {
            contents_.push_back(buffer_of(uri->get_ref<const std::string&>(), folder, place));
        } else {
            contents_.push_back(i == 0 ? binary_ : std::string_view{});
        }
        // One without any bytes is left to an extension; whoever needs it fails.
        if (contents_[i].empty()) continue;
        if (size > contents_[i].size()) {
            fail(place + ".byteLength", "it is " + std::to_string(size) + ", but there are " +
                                            std::to_string(contents_[i].size()) + " bytes: is the file truncated?");
        }
        contents_[i] = contents_[i].substr(0, size);
    }
}

std::string_view GltfDocument::buffer_of(std::string_view uri, const std::filesystem::path& folder,
                                         const std::string& place) {
    if (uri.starts_with("data:")) {
        std::optional<std::string> bytes = decode_data_uri(uri);
        if (!bytes) fail(place + ".uri", "it is no data in base64");
        return buffers_.emplace_back(std::move(*bytes));
    }
    const std::optional<std::filesystem::path> path = relative_path_of(uri);
    if (!path || !lies_below(*path, folder))
        fail(place + ".uri", quote(uri) + " is no file below the folder of this one");
    if (const auto known = files_.find(*path); known != files_.end()) return known->second;
    try {
        return files_[*path] = buffers_.emplace_back(read_whole_file(folder / *path, [this] { sink_.tick_now(); }));
    } catch (const Error& error) {
        if (error.code() == ErrorCode::cancelled) throw;
        fail(place + ".uri", error.what());
    }
}

GltfDocument::Bytes GltfDocument::view(std::uint64_t index, const std::string& from) const {
    const Json& view = element("bufferViews", index, from);
    const std::string place = gltf_place("bufferViews", index);
    const std::uint64_t buffer = whole(view, "buffer", place);
    static_cast<void>(element("buffers", buffer, place));
    const std::string_view content = contents_[buffer];
    const std::uint64_t offset = whole(view, "byteOffset", place, 0), size = whole(view, "byteLength", place);
    if (offset > content.size() || size > content.size() - offset) {
        fail(place, "it ends at byte " + std::to_string(offset) + " + " + std::to_string(size) + ", but " +
                        gltf_place("buffers", buffer) + " has " + std::to_string(content.size()));
    }
    return {content.substr(offset, size), whole(view, "byteStride", place, 0)};
}

std::size_t GltfDocument::bytes() const noexcept {
    std::size_t sum = 0;
    for (const std::string_view content : contents_)
        sum += content.size();
    return sum;
}

}  // namespace clbvh::io
