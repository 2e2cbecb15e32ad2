#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/read/mesh_sink.hpp"

namespace clbvh::io {

/// The place of an element of an array of the file, for errors: "nodes[3]".
[[nodiscard]] std::string gltf_place(const char* array, std::uint64_t index);

/// A glTF 2.0 file taken apart: its JSON, and the bytes of its buffers. Every access is checked, and what is wrong is
/// an Error(io) that names the file and the place, such as "accessors[3].count".
class GltfDocument {
public:
    using Json = nlohmann::json;

    /// `text` is that of a .gltf or .glb file and outlives the document; buffers with a relative URI are files in
    /// `folder` or below it. Throws Error(unsupported) for an extension that the file requires and nobody here knows.
    GltfDocument(std::string_view text, const std::filesystem::path& folder, MeshSink& sink);

    [[nodiscard]] const Json& root() const noexcept { return json_; }
    /// Element `index` of the array `name`; `from` says who refers to it.
    [[nodiscard]] const Json& element(const char* name, std::uint64_t index, const std::string& from) const;
    /// How many elements the array has; 0 where it is missing.
    [[nodiscard]] std::size_t count(const char* name) const;
    /// A whole number of at least 0 in an object of that place; `missing` where there is none.
    [[nodiscard]] std::uint64_t whole(const Json& object, const char* name, const std::string& place,
                                      std::optional<std::uint64_t> missing = std::nullopt) const;
    /// An array of exactly `size` numbers; empty where it is missing.
    [[nodiscard]] std::vector<double> numbers(const Json& object, const char* name, std::size_t size,
                                              const std::string& place) const;
    /// The object or array of that name; null where it is missing.
    [[nodiscard]] const Json* find(const Json& object, const char* name, Json::value_t type,
                                   const std::string& place) const;
    /// Bytes [offset, offset + size) of a buffer view, and the view's stride (0: none).
    struct Bytes {
        std::string_view bytes;
        std::size_t stride = 0;
    };
    /// The bytes of a buffer view.
    [[nodiscard]] Bytes view(std::uint64_t index, const std::string& from) const;
    /// Bytes of all buffers.
    [[nodiscard]] std::size_t bytes() const noexcept;

    [[noreturn]] void fail(const std::string& place, const std::string& what) const { sink_.fail(place + ": " + what); }

private:
    void parse(std::string_view json);
    void check_version_and_extensions() const;
    void load_buffers(const std::filesystem::path& folder);
    [[nodiscard]] std::string_view buffer_of(std::string_view uri, const std::filesystem::path& folder,
                                             const std::string& place);

    MeshSink& sink_;
    Json json_;
    std::string_view binary_;                                  // the second chunk of a .glb file
    std::deque<std::string> buffers_;                          // those that are not binary_
    std::map<std::filesystem::path, std::string_view> files_;  // of them: a file is read once
    std::vector<std::string_view> contents_;
};

}  // namespace clbvh::io
