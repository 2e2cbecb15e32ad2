#include "io/ply.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "clbvh/core/error.hpp"
#include "io/input_file.hpp"
#include "io/ply_header.hpp"
#include "io/ply_values.hpp"
#include "io/polygon.hpp"

namespace clbvh::io {
namespace {

bool is_corner_list(const PlyProperty& property) {
    return property.is_list && is_integer(property.type) &&
           (property.name == "vertex_indices" || property.name == "vertex_index");
}

/// Reads a PLY file's body. Memory is set aside only for as many vertices and faces as the file can hold.
template <typename Values>
class PlyReader {
public:
    PlyReader(const PlyHeader& header, Values values, const std::filesystem::path& path)
        : header_(header), values_(std::move(values)), path_(path) {}

    Mesh read() {
        check_elements();
        for (const PlyElement& element : header_.elements) {
            element_ = &element;
            item_ = 0;
            check_count();
            if (element.name == "vertex") {
                read_vertices();
            } else if (element.name == "face") {
                read_faces();
            } else {
                skip_items();
            }
        }
        return std::move(mesh_);
    }

private:
    void check_elements() const {
        const auto vertex = std::ranges::find(header_.elements, "vertex", &PlyElement::name);
        const auto face = std::ranges::find(header_.elements, "face", &PlyElement::name);
        if (vertex == header_.elements.end()) fail_file("the header has no element \"vertex\"");
        if (face == header_.elements.end()) fail_file("the header has no element \"face\": there are no triangles");
        if (face < vertex) fail_file(R"(element "face" comes before element "vertex", which is not supported)");
        if (std::ranges::count_if(face->properties, is_corner_list) != 1) {
            fail_file(R"(element "face" has no list "vertex_indices" of integers)");
        }
    }

    /// Refuses a count that the rest of the file has no room for.
    void check_count() const {
        std::size_t bytes = 0;
        for (const PlyProperty& property : element_->properties) {
            // A list may be empty: only its count is sure.
            bytes += size_of(property.is_list ? property.count_type : property.type);
        }
        const std::uint64_t room = values_.room_for(element_->properties.size(), bytes);
        if (element_->count <= room) return;
        fail_file("the header promises " + std::to_string(element_->count) + " of element \"" + element_->name +
                  "\", but the file has room for " + std::to_string(room) + " at most: is it truncated?");
    }

    void read_vertices() {
        const std::vector<float*> targets = coordinate_targets();
        mesh_.vertices.reserve(element_->count);
        for (item_ = 0; item_ < element_->count; ++item_) {
            for (std::size_t i = 0; i < targets.size(); ++i) {
                const PlyProperty& property = element_->properties[i];
                if (property.is_list) {
                    skip_list(property);
                } else if (const double value = take(property.type); targets[i] != nullptr) {
                    *targets[i] = static_cast<float>(value);
                }
            }
            mesh_.vertices.push_back(vertex_);
        }
    }

    /// For each property of the vertex, which coordinate it holds; null where none.
    std::vector<float*> coordinate_targets() {
        std::vector<float*> targets(element_->properties.size(), nullptr);
        const std::pair<std::string_view, float*> axes[] = {{"x", &vertex_.x}, {"y", &vertex_.y}, {"z", &vertex_.z}};
        for (const auto& [name, coordinate] : axes) {
            const auto found = std::ranges::find(element_->properties, name, &PlyProperty::name);
            if (found == element_->properties.end() || found->is_list) {
                fail_file(R"(element "vertex" has no property ")" + std::string(name) + '"');
            }
            targets[static_cast<std::size_t>(found - element_->properties.begin())] = coordinate;
        }
        return targets;
    }

    void read_faces() {
        std::vector<std::uint32_t> corners;
        mesh_.triangles.reserve(element_->count);
        for (item_ = 0; item_ < element_->count; ++item_) {
            for (const PlyProperty& property : element_->properties) {
                if (is_corner_list(property)) {
                    take_corners(property, corners);
                } else {
                    skip(property);
                }
            }
            append_polygon(corners, mesh_);
        }
    }

    void take_corners(const PlyProperty& property, std::vector<std::uint32_t>& corners) {
        const std::uint64_t count = take_count(property.count_type);
        if (count < 3) fail("a face needs three vertices, this one has " + std::to_string(count));
        corners.clear();
        for (std::uint64_t i = 0; i < count; ++i) {
            const double index = take(property.type);
            if (!is_whole(index) || index >= static_cast<double>(mesh_.vertices.size())) {
                fail("vertex " + number(index) + " does not exist; the file has " +
                     std::to_string(mesh_.vertices.size()) + ", counted from 0");
            }
            corners.push_back(static_cast<std::uint32_t>(index));
        }
    }

    void skip_items() {
        for (item_ = 0; item_ < element_->count; ++item_) {
            for (const PlyProperty& property : element_->properties)
                skip(property);
        }
    }

    void skip(const PlyProperty& property) {
        if (property.is_list) {
            skip_list(property);
        } else {
            take(property.type);
        }
    }

    void skip_list(const PlyProperty& property) {
        const std::uint64_t count = take_count(property.count_type);
        for (std::uint64_t i = 0; i < count; ++i)
            take(property.type);
    }

    std::uint64_t take_count(PlyType type) {
        const double count = take(type);
        if (!is_whole(count)) fail("a list of " + number(count) + " entries");
        return static_cast<std::uint64_t>(count);
    }

    double take(PlyType type) {
        const std::optional<double> value = values_.take(type);
        if (!value) fail(values_.failure());
        return *value;
    }

    /// A whole number that fits 32 bits.
    static bool is_whole(double value) { return value >= 0.0 && value <= 4294967295.0 && value == std::floor(value); }

    static std::string number(double value) {
        return value == std::floor(value) && std::abs(value) < 1e15 ? std::to_string(static_cast<std::int64_t>(value))
                                                                    : std::to_string(value);
    }

    [[noreturn]] void fail(const std::string& what) const {
        fail_file(element_->name + " " + std::to_string(item_) + " (" + values_.where() + "): " + what);
    }

    [[noreturn]] void fail_file(const std::string& what) const {
        throw Error(ErrorCode::io, path_.string() + ": " + what);
    }

    const PlyHeader& header_;
    Values values_;
    const std::filesystem::path& path_;
    const PlyElement* element_ = nullptr;
    std::uint64_t item_ = 0;
    Vec3 vertex_;
    Mesh mesh_;
};

}  // namespace

Mesh load_ply(const std::filesystem::path& path) {
    const std::string file = read_whole_file(path);
    const PlyHeader header = parse_ply_header(file, path);
    switch (header.format) {
        case PlyFormat::ascii: return PlyReader(header, TextPlyValues(file, header.body), path).read();
        case PlyFormat::binary_little_endian:
            return PlyReader(header, BinaryPlyValues<std::endian::little>(file, header.body), path).read();
        case PlyFormat::binary_big_endian:
            return PlyReader(header, BinaryPlyValues<std::endian::big>(file, header.body), path).read();
    }
    return {};
}

}  // namespace clbvh::io
