#include "io/read/ply.hpp"

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
#include "io/read/ply_header.hpp"
#include "io/read/ply_values.hpp"
#include "io/read/polygon.hpp"

namespace clbvh::io {
namespace {

constexpr std::string_view kStrips = "tristrips";

bool is_corner_list(const PlyProperty& property) {
    return property.is_list && is_integer(property.type) &&
           (property.name == "vertex_indices" || property.name == "vertex_index");
}

/// Reads a PLY file's body. Memory is set aside only for as many vertices and faces as the file can hold.
template <typename Values>
class PlyReader {
public:
    PlyReader(const PlyHeader& header, Values values, MeshSink& sink)
        : header_(header), values_(std::move(values)), sink_(sink), mesh_(sink.mesh) {}

    void read() {
        check_elements();
        for (const PlyElement& element : header_.elements) {
            element_ = &element;
            item_ = 0;
            check_count();
            if (element.name == "vertex") {
                read_vertices();
            } else if (is_of_corners(element)) {
                read_corners();
            } else {
                skip_items();
            }
        }
    }

    [[nodiscard]] const Values& values() const noexcept { return values_; }

private:
    void check_elements() const {
        const auto vertex = std::ranges::find(header_.elements, "vertex", &PlyElement::name);
        if (vertex == header_.elements.end()) sink_.fail("the header has no element \"vertex\"");
        bool is_any = false;
        for (auto element = header_.elements.begin(); element != header_.elements.end(); ++element) {
            if (!is_of_corners(*element)) continue;
            is_any = true;
            const std::string name = "element \"" + element->name + '"';
            if (element < vertex) sink_.fail(name + R"( comes before element "vertex", which is not supported)");
            if (std::ranges::count_if(element->properties, is_corner_list) != 1)
                sink_.fail(name + R"( has no list "vertex_indices" of integers)");
        }
        if (!is_any) sink_.fail(R"(the header has no element "face" or "tristrips": there are no triangles)");
    }
    static bool is_of_corners(const PlyElement& element) { return element.name == "face" || element.name == kStrips; }

    /// Refuses a count that the rest of the file has no room for.
    void check_count() const {
        std::size_t bytes = 0;
        for (const PlyProperty& property : element_->properties) {
            // A list may be empty: only its count is sure.
            bytes += size_of(property.is_list ? property.count_type : property.type);
        }
        const std::uint64_t room = values_.room_for(element_->properties.size(), bytes);
        if (element_->count <= room) return;
        sink_.fail("the header promises " + std::to_string(element_->count) + " of element \"" + element_->name +
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
            sink_.add_vertex(vertex_);
            end_item();
        }
    }

    /// For each property of the vertex, which coordinate it holds; null where none.
    std::vector<float*> coordinate_targets() {
        std::vector<float*> targets(element_->properties.size(), nullptr);
        const std::pair<std::string_view, float*> axes[] = {{"x", &vertex_.x}, {"y", &vertex_.y}, {"z", &vertex_.z}};
        for (const auto& [name, coordinate] : axes) {
            const auto found = std::ranges::find(element_->properties, name, &PlyProperty::name);
            if (found == element_->properties.end() || found->is_list) {
                sink_.fail(R"(element "vertex" has no property ")" + std::string(name) + '"');
            }
            targets[static_cast<std::size_t>(found - element_->properties.begin())] = coordinate;
        }
        return targets;
    }

    void read_corners() {
        const bool is_strips = element_->name == kStrips;
        std::vector<std::uint32_t> corners;
        if (!is_strips) mesh_.triangles.reserve(element_->count);
        for (item_ = 0; item_ < element_->count; ++item_) {
            for (const PlyProperty& property : element_->properties) {
                if (!is_corner_list(property)) {
                    skip(property);
                } else if (is_strips) {
                    take_strips(property, corners);
                } else {
                    take_corners(property, corners);
                    sink_.add_face(corners);
                }
            }
            end_item();
        }
    }

    void take_corners(const PlyProperty& property, std::vector<std::uint32_t>& corners) {
        corners.clear();
        for (std::uint64_t left = take_count(property.count_type); left > 0; --left)
            corners.push_back(vertex_number(take(property.type)));
    }

    /// One list may hold many strips: -1 ends each.
    void take_strips(const PlyProperty& property, std::vector<std::uint32_t>& strip) {
        strip.clear();
        for (std::uint64_t left = take_count(property.count_type); left > 0; --left) {
            const double index = take(property.type);
            if (index != -1.0) {
                strip.push_back(vertex_number(index));
                continue;
            }
            sink_.add_strip(strip);
            strip.clear();
        }
        sink_.add_strip(strip);
    }

    std::uint32_t vertex_number(double index) const {
        if (!is_whole(index) || index >= static_cast<double>(mesh_.vertices.size())) {
            fail("vertex " + number_text(index) + " does not exist; the file has " +
                 std::to_string(mesh_.vertices.size()) + ", counted from 0");
        }
        return static_cast<std::uint32_t>(index);
    }

    void skip_items() {
        for (item_ = 0; item_ < element_->count; ++item_) {
            for (const PlyProperty& property : element_->properties)
                skip(property);
            end_item();
        }
    }

    void end_item() {
        values_.end_item();
        sink_.tick(values_.position());
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
        if (!is_whole(count)) fail("a list of " + number_text(count) + " entries");
        return static_cast<std::uint64_t>(count);
    }

    double take(PlyType type) {
        const std::optional<double> value = values_.take(type);
        if (!value) fail(values_.failure());
        return *value;
    }

    /// A whole number that fits 32 bits.
    static bool is_whole(double value) { return value >= 0.0 && value <= 4294967295.0 && value == std::floor(value); }

    [[noreturn]] void fail(const std::string& what) const {
        sink_.fail(element_->name + " " + std::to_string(item_) + " (" + values_.where() + "): " + what);
    }

    const PlyHeader& header_;
    Values values_;
    MeshSink& sink_;
    Mesh& mesh_;
    const PlyElement* element_ = nullptr;
    std::uint64_t item_ = 0;
    Vec3 vertex_;
};

/// One number behind the other, wherever lines end, as the format says. Where that leaves something over, or does not
/// work, rows may be longer than the header says.
void read_ascii(std::string_view text, const PlyHeader& header, MeshSink& sink) {
    const auto read = [&](bool is_by_lines) {
        PlyReader reader(header, TextPlyValues(text, header.body, is_by_lines), sink);
        reader.read();
        return reader.values().at_end();
    };
    std::optional<Error> fault;
    try {
        if (read(false)) return;
    } catch (const Error& error) {
        if (error.code() != ErrorCode::io) throw;
        fault = error;
    }
    MeshSink::Content first = sink.take_content();
    try {
        read(true);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::io) throw;
        if (fault) throw *fault;
        sink.put_content(std::move(first));
    }
}

}  // namespace

void read_ply(std::string_view text, MeshSink& sink) {
    const PlyHeader header = parse_ply_header(text, sink.name());
    switch (header.format) {
        case PlyFormat::ascii: return read_ascii(text, header, sink);
        case PlyFormat::binary_little_endian:
            return PlyReader(header, BinaryPlyValues<std::endian::little>(text, header.body), sink).read();
        case PlyFormat::binary_big_endian:
            return PlyReader(header, BinaryPlyValues<std::endian::big>(text, header.body), sink).read();
    }
}

}  // namespace clbvh::io
