#include "io/read/stl.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "io/read/little_endian.hpp"
#include "io/read/words.hpp"

namespace clbvh::io {
namespace {

constexpr std::size_t kHeaderBytes = 84, kCountAt = 80, kFacetBytes = 50, kNormalBytes = 12;

bool is_keyword(std::string_view word, std::string_view keyword) {
    return std::ranges::equal(word, keyword, {}, lower_case);
}

/// Text begins with "solid" and holds no zero byte where a facet would stand; a binary file may begin so as well.
bool is_ascii(std::string_view text) {
    std::string_view start = text.substr(0, 256);
    start.remove_prefix(std::min(start.find_first_not_of(" \t\r\n"), start.size()));
    if (!is_keyword(start.substr(0, 5), "solid")) return false;
    if (text.size() < kHeaderBytes) return true;
    const std::uint64_t facets = little_endian_word(text, kCountAt);
    if (kHeaderBytes + facets * kFacetBytes == text.size()) return false;
    return text.substr(0, 1024).find('\0') == std::string_view::npos;
}

void read_binary(std::string_view text, MeshSink& sink) {
    if (text.size() < kHeaderBytes) {
        sink.fail("neither ASCII STL, which begins with \"solid\", nor binary STL, whose header has 84 bytes: this " +
                  ("file has " + std::to_string(text.size())));
    }
    const std::uint64_t facets = little_endian_word(text, kCountAt);
    const std::uint64_t room = (text.size() - kHeaderBytes) / kFacetBytes;
    if (facets > room) {
        sink.fail("the header promises " + std::to_string(facets) + " triangles, but the file has room for " +
                  std::to_string(room) + ": is it truncated?");
    }
    sink.mesh.vertices.reserve(3 * facets);
    sink.mesh.triangles.reserve(facets);
    for (std::uint64_t facet = 0; facet < facets; ++facet) {
        const std::size_t begin = kHeaderBytes + facet * kFacetBytes + kNormalBytes;
        std::array<std::uint32_t, 3> corners{};
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const auto coordinate = [&](std::size_t axis) {
                return std::bit_cast<float>(little_endian_word(text, begin + 12 * corner + 4 * axis));
            };
            corners[corner] = sink.add_vertex({coordinate(0), coordinate(1), coordinate(2)});
        }
        sink.add_triangle(corners[0], corners[1], corners[2]);
        sink.tick(begin);
    }
}

class AsciiReader {
public:
    AsciiReader(std::string_view text, MeshSink& sink) : lines_(text), sink_(sink) {}

    void read() {
        std::uint64_t solids = 0;
        while (!lines_.at_end()) {
            sink_.tick(lines_.place());
            std::string_view line = lines_.take();
            // Keywords may share a line.
            for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
                if (is_keyword(word, "solid")) {
                    ++solids;
                    break;  // what follows is its name
                }
                if (is_keyword(word, "endsolid")) break;
                take(word, line);
            }
        }
        if (is_open_) fail("the file ends within a facet");
        sink_.report.meshes = sink_.report.instances = std::max<std::uint64_t>(solids, 1);
    }

private:
    void take(std::string_view word, std::string_view& line) {
        // The normal is of no interest; some files have words there.
        is_in_normal_ = is_in_normal_ && !is_keyword(word, "outer") && !is_keyword(word, "vertex");
        if (is_in_normal_ && !is_keyword(word, "endfacet")) return;
        if (is_keyword(word, "facet")) {
            if (is_open_) fail("a facet within a facet");
            is_open_ = true;
            is_in_normal_ = true;
            corners_.clear();
        } else if (is_keyword(word, "vertex")) {
            if (!is_open_) fail("a vertex outside a facet");
            corners_.push_back(take_vertex(line));
        } else if (is_keyword(word, "endfacet")) {
            if (!is_open_) fail("endfacet without a facet");
            is_open_ = false;
            sink_.add_face(corners_);
        } else if (!is_keyword(word, "outer") && !is_keyword(word, "loop") && !is_keyword(word, "endloop")) {
            fail(quote(word) + " is no keyword of STL");
        }
    }

    std::uint32_t take_vertex(std::string_view& line) {
        std::array<double, 3> at{};
        if (const std::string fault = take_coordinates(line, at); !fault.empty()) fail(fault);
        return sink_.add_vertex({static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2])});
    }

    [[noreturn]] void fail(const std::string& what) const {
        sink_.fail("line " + std::to_string(lines_.number()) + ": " + what);
    }

    Lines lines_;
    MeshSink& sink_;
    bool is_open_ = false, is_in_normal_ = false;
    std::vector<std::uint32_t> corners_;
};

}  // namespace

void read_stl(std::string_view text, MeshSink& sink) {
    const std::string_view content = without_byte_order_mark(text);
    if (is_ascii(content)) return AsciiReader(content, sink).read();
    read_binary(text, sink);
}

}  // namespace clbvh::io
