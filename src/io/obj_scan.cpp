#include "io/obj_scan.hpp"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "clbvh/core/error.hpp"

namespace clbvh::io {
namespace {

constexpr std::string_view kBlanks = " \t";

/// Takes the next word off the front of `line`; empty where there is none.
std::string_view take_word(std::string_view& line) {
    line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
    const std::size_t length = std::min(line.find_first_of(kBlanks), line.size());
    const std::string_view word = line.substr(0, length);
    line.remove_prefix(length);
    return word;
}

std::optional<float> parse_coordinate(std::string_view word) {
    if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
    // Read as a double, because from_chars calls a float that underflows to zero an error.
    double value = 0.0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
    return static_cast<float>(value);
}

/// Takes an index, which is never zero, off the front of a face's corner.
std::optional<std::int32_t> take_index(std::string_view& corner) {
    std::int32_t value = 0;
    const auto [end, error] = std::from_chars(corner.data(), corner.data() + corner.size(), value);
    if (error != std::errc{} || value == 0) return std::nullopt;
    corner.remove_prefix(static_cast<std::size_t>(end - corner.data()));
    return value;
}

/// The vertex index of a face's corner: v, v/vt, v//vn or v/vt/vn.
std::optional<std::int32_t> parse_corner(std::string_view corner) {
    const std::optional<std::int32_t> vertex = take_index(corner);
    if (!vertex) return std::nullopt;
    for (int field = 1; field <= 2 && corner.starts_with('/'); ++field) {
        corner.remove_prefix(1);
        if (field == 1 && corner.starts_with('/')) continue;
        if (!take_index(corner)) return std::nullopt;
    }
    return corner.empty() ? vertex : std::nullopt;
}

class ObjScanner {
public:
    ObjScanner(std::string_view text, const std::filesystem::path& path) : rest_(text), path_(path) {}

    std::vector<Vec3> scan() {
        if (rest_.find('\0') != std::string_view::npos) {
            throw Error(ErrorCode::io, path_.string() + ": not an OBJ file: it holds zero bytes, text does not");
        }
        while (!rest_.empty()) {
            const std::string_view line = take_line();
            ++line_number_;
            scan_line(line);
        }
        check_forward_references();
        return std::move(vertices_);
    }

private:
    /// A reference to a vertex that was not defined yet.
    struct ForwardReference {
        std::uint64_t line;
        std::int32_t index;
    };

    /// Lines end with LF, CR LF or CR, as tinyobjloader sees them.
    std::string_view take_line() {
        std::size_t length = 0;
        while (length < rest_.size() && rest_[length] != '\n' && rest_[length] != '\r')
            ++length;
        const std::string_view line = rest_.substr(0, length);
        rest_.remove_prefix(length);
        rest_.remove_prefix(rest_.starts_with("\r\n") ? 2 : std::min<std::size_t>(1, rest_.size()));
        return line;
    }

    void scan_line(std::string_view line) {
        std::string_view words = line;
        const std::string_view keyword = take_word(words);
        if (keyword == "v") scan_vertex(words);
        if (keyword == "f") scan_face(words);
    }

    /// Words after the third are a weight or a colour, and of no interest.
    void scan_vertex(std::string_view words) {
        float coordinates[3];
        for (float& coordinate : coordinates) {
            const std::string_view word = take_word(words);
            if (word.empty()) fail("a vertex needs three coordinates");
            const std::optional<float> value = parse_coordinate(word);
            if (!value) fail(quoted(word) + " is not a coordinate");
            coordinate = *value;
        }
        vertices_.push_back({coordinates[0], coordinates[1], coordinates[2]});
    }

    void scan_face(std::string_view words) {
        int corners = 0;
        for (std::string_view word = take_word(words); !word.empty(); word = take_word(words)) {
            const std::optional<std::int32_t> index = parse_corner(word);
            if (!index) fail(quoted(word) + " is not a corner of a face (v, v/vt, v//vn or v/vt/vn)");
            check_index(*index);
            ++corners;
        }
        if (corners < 3) fail("a face needs three vertices, this one has " + std::to_string(corners));
    }

    void check_index(std::int32_t index) {
        const auto count = static_cast<std::int64_t>(vertices_.size());
        if (index < 0 && -std::int64_t{index} > count) fail_index(line_number_, index);
        if (index > count && index > highest_forward_) {
            highest_forward_ = index;
            forward_references_.push_back({line_number_, index});
        }
    }

    /// Only references above all earlier ones were kept: the first bad one is among them.
    void check_forward_references() const {
        for (const ForwardReference& reference : forward_references_) {
            if (static_cast<std::size_t>(reference.index) > vertices_.size()) {
                fail_index(reference.line, reference.index);
            }
        }
    }

    static std::string quoted(std::string_view word) { return '"' + std::string(word.substr(0, 40)) + '"'; }

    [[noreturn]] void fail_index(std::uint64_t line, std::int32_t index) const {
        fail_at(line, "vertex " + std::to_string(index) + " does not exist; the file has " +
                          std::to_string(vertices_.size()) + (index < 0 ? " up to here" : ""));
    }

    [[noreturn]] void fail(const std::string& what) const { fail_at(line_number_, what); }

    [[noreturn]] void fail_at(std::uint64_t line, const std::string& what) const {
        throw Error(ErrorCode::io, path_.string() + ", line " + std::to_string(line) + ": " + what);
    }

    std::string_view rest_;
    const std::filesystem::path& path_;
    std::uint64_t line_number_ = 0;
    std::vector<Vec3> vertices_;
    std::vector<ForwardReference> forward_references_;
    std::int32_t highest_forward_ = 0;
};

}  // namespace

std::vector<Vec3> scan_obj(std::string_view text, const std::filesystem::path& path) {
    return ObjScanner(text, path).scan();
}

}  // namespace clbvh::io
