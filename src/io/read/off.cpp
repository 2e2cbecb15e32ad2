#include "io/read/off.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "clbvh/core/error.hpp"
#include "io/read/words.hpp"

namespace clbvh::io {
namespace {

constexpr const char* kMissing = "needs more coordinates";

class OffReader {
public:
    OffReader(std::string_view text, MeshSink& sink) : text_(text), lines_(text), sink_(sink) {}

    void read() {
        std::string_view line = take_line([] { return "the header"; });
        take_name(line);
        const std::uint64_t vertices = take_count(line, "vertices"), faces = take_count(line, "faces");
        check_room(vertices, "vertices");
        check_room(faces, "faces");
        for (vertex_ = 0; vertex_ < vertices; ++vertex_)
            read_vertex(take_line([&] { return name_of("vertex", vertex_, vertices); }));
        for (std::uint64_t face = 0; face < faces; ++face)
            read_face(take_line([&] { return name_of("face", face, faces); }));
    }

private:
    static std::string name_of(const char* kind, std::uint64_t number, std::uint64_t count) {
        return std::string(kind) + ' ' + std::to_string(number) + " of " + std::to_string(count);
    }

    /// The next line that says something, without its comment. what() is asked for its name where there is none.
    template <typename What>
    std::string_view take_line(const What& what) {
        while (!lines_.at_end()) {
            sink_.tick(lines_.place());
            std::string_view line = lines_.take();
            line = line.substr(0, line.find('#'));
            if (line.find_first_not_of(" \t\v\f") != std::string_view::npos) return line;
        }
        fail(std::string("the file ends before ") + what());
    }

    /// Takes the variant's name, [ST][C][N][4][n]OFF, and leaves the line of the counts.
    void take_name(std::string_view& line) {
        std::string_view rest = line;
        const std::string_view name = take_word(rest);
        if (!name.ends_with("OFF")) {
            if (parse_number(name)) return;  // the name is missing
            fail(quote(name) + " is no variant of OFF: not an OFF file");
        }
        std::string_view variant = name.substr(0, name.size() - 3);
        for (const std::string_view part : {"ST", "C", "N", "4"}) {
            if (!variant.starts_with(part)) continue;
            variant.remove_prefix(part.size());
            has_weights_ = has_weights_ || part == "4";
        }
        if (variant == "n") refuse("nOFF, of any number of dimensions, is");
        if (!variant.empty()) fail(quote(name) + " is no variant of OFF: not an OFF file");
        std::string_view behind = rest;
        const std::string_view word = take_word(behind);
        if (word == "BINARY") refuse("binary OFF is");
        line = word.empty() ? take_line([] { return "the counts"; }) : rest;
    }

    std::uint64_t take_count(std::string_view& line, const std::string& what) {
        const std::string_view word = take_word(line);
        const std::optional<std::int64_t> count = parse_whole(word);
        if (!count || *count < 0) fail(quote(word) + " is not a count of " + what);
        return static_cast<std::uint64_t>(*count);
    }
    /// Each takes a line of two bytes at least.
    void check_room(std::uint64_t count, const std::string& what) const {
        const std::uint64_t room = (text_.size() - lines_.place() + 1) / 2;
        if (count <= room) return;
        fail("the header promises " + std::to_string(count) + ' ' + what + ", but the file has room for " +
             std::to_string(room) + " at most: is it truncated?");
    }

    void read_vertex(std::string_view line) {
        std::array<double, 4> values{0.0, 0.0, 0.0, 1.0};
        const std::string fault = take_coordinates(line, std::span(values).first(has_weights_ ? 4 : 3), kMissing);
        if (fault == kMissing) fail("vertex " + std::to_string(vertex_) + ' ' + fault);
        if (!fault.empty()) fail(fault);
        if (values[3] == 0.0)
            fail("vertex " + std::to_string(vertex_) + " lies infinitely far: its fourth number is 0");
        sink_.add_vertex({static_cast<float>(values[0] / values[3]), static_cast<float>(values[1] / values[3]),
                          static_cast<float>(values[2] / values[3])});
    }

    /// What stands behind the corners is a colour.
    void read_face(std::string_view line) {
        const std::string_view word = take_word(line);
        const std::optional<std::int64_t> count = parse_whole(word);
        if (!count || *count < 0) fail(quote(word) + " is not a count of corners");
        corners_.clear();
        for (std::int64_t i = 0; i < *count; ++i) {
            const std::string_view corner = take_word(line);
            if (corner.empty()) {
                fail("a face of " + std::to_string(*count) + " corners has " + std::to_string(i) + " here");
            }
            const std::optional<std::int64_t> index = parse_whole(corner);
            if (!index) fail(quote(corner) + " is not a vertex");
            if (*index < 0 || static_cast<std::uint64_t>(*index) >= sink_.mesh.vertices.size()) {
                fail("vertex " + std::string(corner) + " does not exist; the file has " +
                     std::to_string(sink_.mesh.vertices.size()) + ", counted from 0");
            }
            corners_.push_back(static_cast<std::uint32_t>(*index));
        }
        sink_.add_face(corners_);
    }

    [[noreturn]] void refuse(const std::string& what) const {
        throw Error(ErrorCode::unsupported, sink_.name() + ": " + what + " not read; save it as OFF in ASCII");
    }
    [[noreturn]] void fail(const std::string& what) const {
        sink_.fail("line " + std::to_string(lines_.number()) + ": " + what);
    }

    std::string_view text_;
    Lines lines_;
    MeshSink& sink_;
    bool has_weights_ = false;
    std::uint64_t vertex_ = 0;
    std::vector<std::uint32_t> corners_;
};

}  // namespace

void read_off(std::string_view text, MeshSink& sink) {
    if (is_utf16(text)) sink.fail("text in UTF-16, which is not read; save it as UTF-8");
    OffReader(without_byte_order_mark(text), sink).read();
}

}  // namespace clbvh::io
