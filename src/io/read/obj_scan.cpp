#include "io/read/obj_scan.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "clbvh/core/error.hpp"
#include "io/read/words.hpp"

namespace clbvh::io {
namespace {

/// A vertex's index, which is never zero.
std::optional<std::int32_t> parse_index(std::string_view word) {
    const std::optional<std::int64_t> index = parse_whole(word);
    if (!index || *index == 0 || *index != static_cast<std::int32_t>(*index)) return std::nullopt;
    return static_cast<std::int32_t>(*index);
}

/// Whether a word could be an index, of whatever size.
bool is_signed_digits(std::string_view word) {
    if (word.starts_with('-') || word.starts_with('+')) word.remove_prefix(1);
    return !word.empty() && word.find_first_not_of("0123456789") == std::string_view::npos;
}

/// The vertex index of a face's corner: v, v/vt, v//vn or v/vt/vn, of which what stands behind v may be empty.
std::optional<std::int32_t> parse_corner(std::string_view corner) {
    std::size_t end = corner.find('/');
    const std::string_view vertex = corner.substr(0, end);
    for (int field = 1; end != std::string_view::npos; ++field) {
        corner.remove_prefix(end + 1);
        end = corner.find('/');
        const std::string_view other = corner.substr(0, end);
        if (field > 2 || !(other.empty() || is_signed_digits(other))) return std::nullopt;
    }
    return parse_index(vertex);
}

class ObjScanner {
public:
    ObjScanner(std::string_view text, MeshSink& sink) : lines_(without_byte_order_mark(text)), sink_(sink) {
        if (is_utf16(text)) sink_.fail("text in UTF-16, which is not read; save it as UTF-8");
        if (text.find('\0') != std::string_view::npos)
            sink_.fail("not an OBJ file: it holds zero bytes, text does not");
    }

    std::string scan() {
        while (!lines_.at_end()) {
            sink_.tick(lines_.place());
            std::string_view line = lines_.take();
            line_number_ = lines_.number();
            if (take_backslash(line)) line = take_continued(line);
            scan_line(line.substr(0, line.find('#')));
        }
        check_forward_references();
        return std::move(faces_);
    }

private:
    /// A reference to a vertex that was not defined yet.
    struct ForwardReference {
        std::uint64_t line;
        std::int32_t index;
    };

    /// Whether the next line continues this one; the backslash that says so is taken off. A comment ends with its line:
    /// names of folders, which stand there, end with a backslash, too.
    static bool take_backslash(std::string_view& line) {
        const std::size_t last = line.find_last_not_of(" \t");
        if (last == std::string_view::npos || line[last] != '\\' || line.find('#') != std::string_view::npos)
            return false;
        line = line.substr(0, last);
        return true;
    }

    /// The line with those that continue it.
    std::string_view take_continued(std::string_view line) {
        joined_.clear();
        do {
            joined_.append(line).push_back(' ');
            line = lines_.at_end() ? std::string_view{} : lines_.take();
        } while (take_backslash(line));
        joined_.append(line);
        return joined_;
    }

    void scan_line(std::string_view line) {
        const std::string_view keyword = take_word(line);
        if (keyword == "v") return scan_vertex(line);
        if (keyword == "f" || keyword == "fo") return scan_face(line);
        if (keyword == "l" || keyword == "p") ++sink_.report.points_and_lines;
        if (keyword == "o") ++objects_;
        sink_.report.meshes = std::max<std::uint64_t>(objects_, 1);
    }

    /// Words after the third are a weight or a colour, and of no interest.
    void scan_vertex(std::string_view words) {
        std::array<double, 3> at{};
        if (const std::string fault = take_coordinates(words, at); !fault.empty()) fail(fault);
        sink_.add_vertex({static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2])});
    }

    void scan_face(std::string_view words) {
        corners_.clear();
        for (std::string_view word = take_word(words); !word.empty(); word = take_word(words)) {
            const std::optional<std::int32_t> index = parse_corner(word);
            if (!index) fail(quote(word) + " is not a corner of a face (v, v/vt, v//vn or v/vt/vn)");
            corners_.push_back(absolute(*index));
        }
        if (corners_.size() < 3) return sink_.skip_face();
        faces_ += 'f';
        for (const std::int64_t corner : corners_) {
            char digits[24] = " ";
            const auto end = std::to_chars(digits + 1, std::end(digits), corner).ptr;
            faces_.append(digits, end);
        }
        faces_ += '\n';
    }

    /// The index counted from the first vertex.
    std::int64_t absolute(std::int32_t index) {
        const auto count = static_cast<std::int64_t>(sink_.mesh.vertices.size());
        if (index < 0) {
            if (-std::int64_t{index} > count) fail_index(line_number_, index);
            return count + 1 + index;
        }
        if (index > count && index > highest_forward_) {
            highest_forward_ = index;
            forward_references_.push_back({line_number_, index});
        }
        return index;
    }

    /// Only references above all earlier ones were kept: the first bad one is among them.
    void check_forward_references() const {
        for (const ForwardReference& reference : forward_references_) {
            if (static_cast<std::size_t>(reference.index) > sink_.mesh.vertices.size())
                fail_index(reference.line, reference.index);
        }
    }

    [[noreturn]] void fail_index(std::uint64_t line, std::int32_t index) const {
        fail_at(line, "vertex " + std::to_string(index) + " does not exist; the file has " +
                          std::to_string(sink_.mesh.vertices.size()) + (index < 0 ? " up to here" : ""));
    }

    [[noreturn]] void fail(const std::string& what) const { fail_at(line_number_, what); }

    [[noreturn]] void fail_at(std::uint64_t line, const std::string& what) const {
        throw Error(ErrorCode::io, sink_.name() + ", line " + std::to_string(line) + ": " + what);
    }

    Lines lines_;
    MeshSink& sink_;
    std::uint64_t line_number_ = 0, objects_ = 0;
    std::string joined_, faces_;
    std::vector<std::int64_t> corners_;
    std::vector<ForwardReference> forward_references_;
    std::int32_t highest_forward_ = 0;
};

}  // namespace

std::string scan_obj(std::string_view text, MeshSink& sink) {
    return ObjScanner(text, sink).scan();
}

}  // namespace clbvh::io
