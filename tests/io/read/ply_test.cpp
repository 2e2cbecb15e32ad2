#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "clbvh/io/scene.hpp"
#include "io/temp_folder.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

const std::vector<std::string> kFormats{"ascii", "binary_little_endian", "binary_big_endian"};

/// A PLY file that is written value by value, in any of the formats.
class PlyText {
public:
    PlyText(const std::string& format, const std::string& declarations) : format_(format) {
        text_ = "ply\nformat " + format + " 1.0\n" + declarations + "end_header\n";
    }

    template <typename T>
    PlyText& put(T value) {
        if (format_ == "ascii") {
            std::ostringstream number;
            number << +value << (text_.size() % 3 == 0 ? '\n' : ' ');
            text_ += number.str();
            return *this;
        }
        std::array<char, sizeof(T)> bytes{};
        std::copy_n(reinterpret_cast<const char*>(&value), sizeof(T), bytes.begin());
        if (format_ == "binary_big_endian") std::reverse(bytes.begin(), bytes.end());
        text_.append(bytes.data(), bytes.size());
        return *this;
    }

    [[nodiscard]] const std::string& text() const { return text_; }

private:
    std::string format_;
    std::string text_;
};

/// The usual file: three floats a vertex, lists of a byte and ints.
std::string plain_ply(const std::string& format, const std::vector<Vec3>& vertices,
                      const std::vector<std::vector<std::int32_t>>& faces) {
    PlyText ply(format, "element vertex " + std::to_string(vertices.size()) +
                            "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                            std::to_string(faces.size()) + "\nproperty list uchar int vertex_indices\n");
    for (const Vec3& v : vertices)
        ply.put(v.x).put(v.y).put(v.z);
    for (const std::vector<std::int32_t>& face : faces) {
        ply.put(static_cast<std::uint8_t>(face.size()));
        for (const std::int32_t index : face)
            ply.put(index);
    }
    return ply.text();
}

const std::vector<Vec3> kCorners{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.5f}};

Mesh load(const std::string& text) {
    const TempFolder folder;
    return load_scene(folder.write("mesh.PLY", text));
}

void expect_io_error(const std::string& text, std::initializer_list<std::string> parts) {
    const TempFolder folder;
    const std::string path = folder.write("mesh.ply", text);
    expect_error(ErrorCode::io, {path}, [&] { (void)load_scene(path); });
    expect_error(ErrorCode::io, parts, [&] { (void)load_scene(path); });
}

/// Replaces one line of a header.
std::string with(std::string text, const std::string& line, const std::string& replacement) {
    return text.replace(text.find(line), line.size(), replacement);
}

}  // namespace

TEST_CASE("PLY files of every format give the same triangles") {
    for (const std::string& format : kFormats) {
        INFO(format);
        const Mesh mesh = load(plain_ply(format, kCorners, {{0, 1, 2}, {0, 1, 2, 3}, {3, 2, 1}}));
        CHECK(mesh.vertices == kCorners);
        CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}, {3, 2, 1}});
    }
}

TEST_CASE("PLY coordinates and indices may have any type, and what else is there is skipped") {
    for (const std::string& format : kFormats) {
        INFO(format);
        PlyText ply(
            format,
            "comment element vertex 7\nobj_info property\nelement sensor 2\nproperty list uint16 short hits\n"
            "element vertex 3\nproperty uchar red\nproperty double z\nproperty int8 x\nproperty list char float w\n"
            "property uint y\nelement face 1\nproperty ushort material\n"
            "property list int uint16 vertex_index\nproperty list uint8 double uv\nelement edge 1\n"
            "property float64 weight\n");
        ply.put(std::uint16_t{2}).put(std::int16_t{-1}).put(std::int16_t{300}).put(std::uint16_t{0});
        for (int i = 0; i < 3; ++i) {
            ply.put(std::uint8_t{255}).put(0.5 + i).put(static_cast<std::int8_t>(-i));
            ply.put(std::int8_t{1}).put(9.5f).put(std::uint32_t{3000000000U});
        }
        ply.put(std::uint16_t{7}).put(std::int32_t{3});
        ply.put(std::uint16_t{2}).put(std::uint16_t{0}).put(std::uint16_t{1});
        ply.put(std::uint8_t{1}).put(0.25).put(1.5);
        const Mesh mesh = load(ply.text());
        CHECK(mesh.vertices == std::vector<Vec3>{{0, 3e9f, 0.5f}, {-1, 3e9f, 1.5f}, {-2, 3e9f, 2.5f}});
        CHECK(mesh.triangles == std::vector<Triangle>{{2, 0, 1}});
    }
}

TEST_CASE("PLY coordinates may be NaN or infinite") {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    for (const std::string& format : kFormats) {
        const Mesh mesh = load(plain_ply(format, {{0, kNan, 0}, {1, 0, -kInfinity}, {0, 1, 0}}, {{0, 1, 2}}));
        CHECK(std::isnan(mesh.vertices[0].y));
        CHECK(mesh.vertices[1].z == -kInfinity);
    }
}

TEST_CASE("a PLY header may end its lines with CR LF") {
    std::string text = plain_ply("binary_little_endian", kCorners, {{0, 1, 2}});
    const std::size_t body = text.find("end_header\n") + 11;
    std::string header;
    for (const char c : text.substr(0, body))
        header += c == '\n' ? std::string("\r\n") : std::string(1, c);
    CHECK(load(header + text.substr(body)).vertices == kCorners);
}

TEST_CASE("a PLY file without faces is an empty mesh") {
    for (const std::string& format : kFormats)
        CHECK(load(plain_ply(format, kCorners, {})).triangles.empty());
}

TEST_CASE("a PLY file that is cut anywhere is refused") {
    const TempFolder folder;
    for (const std::string& format : kFormats) {
        const std::string text = plain_ply(format, kCorners, {{0, 1, 2}, {0, 1, 2, 3}});
        // An ASCII file may lack the space after its last number.
        const std::size_t needed = format == "ascii" ? text.size() - 1 : text.size();
        for (std::size_t size = 0; size < needed; ++size) {
            const std::string path = folder.write("cut.ply", text.substr(0, size));
            INFO(format << " cut to " << size << " of " << text.size());
            expect_error(ErrorCode::io, {path}, [&] { (void)load_scene(path); });
        }
    }
}

TEST_CASE("a PLY count that the file has no room for is refused before memory is set aside") {
    for (const std::string& format : kFormats) {
        const std::string text = plain_ply(format, kCorners, {{0, 1, 2}});
        for (const std::string count : {"1000", "4000000000", "18446744073709551615"}) {
            expect_io_error(with(text, "element face 1", "element face " + count), {count, "\"face\"", "has room for"});
            expect_io_error(with(text, "element vertex 4", "element vertex " + count), {count, "\"vertex\""});
        }
    }
}

TEST_CASE("PLY faces are checked") {
    for (const std::string& format : kFormats) {
        const std::string where = format == "ascii" ? "line " : "byte ";
        expect_io_error(plain_ply(format, kCorners, {{0, 1, 2}, {0, 1, 4}}),
                        {"face 1 (" + where, "vertex 4 does not exist"});
        expect_io_error(plain_ply(format, kCorners, {{0, -1, 2}}), {"face 0", where, "vertex -1 does not exist"});
    }
}

TEST_CASE("PLY faces of fewer than three corners are skipped and counted") {
    const TempFolder folder;
    for (const std::string& format : kFormats) {
        LoadReport report;
        const std::string path =
            folder.write("few.ply", plain_ply(format, kCorners, {{}, {0, 1, 2}, {0, 1}, {3}, {0, 2, 3}}));
        CHECK(load_scene(path, {{}, &report}).triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}});
        CHECK(report.faces == 5);
        CHECK(report.skipped_faces == 3);
    }
}

TEST_CASE("PLY triangle strips are read, and -1 parts them") {
    const std::string vertices = "element vertex 6\nproperty float x\nproperty float y\nproperty float z\n";
    const std::string corners = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n1 2 0\n";
    const std::string strips = "element tristrips 2\nproperty list int int vertex_indices\nend_header\n";
    const std::string header = "ply\nformat ascii 1.0\n" + vertices + strips + corners;
    // The third triangle of the first strip has a corner twice.
    CHECK(load(header + "9 0 1 2 3 3 -1 2 3 4\n3 3 4 5\n").triangles ==
          std::vector<Triangle>{{0, 1, 2}, {2, 1, 3}, {2, 3, 4}, {3, 4, 5}});
    expect_io_error(header + "3 0 1 -2\n3 0 1 2\n", {"tristrips 0 (line", "vertex -2"});
}

TEST_CASE("PLY files are read as other programs write them") {
    const std::string text = plain_ply("ascii", kCorners, {{0, 1, 2}});
    const std::vector<Triangle> expected{{0, 1, 2}};
    CHECK(load("\xEF\xBB\xBF" + text).triangles == expected);
    CHECK(load(with(text, "format", "comment by X\ncomment\nformat")).triangles == expected);
    CHECK(load(with(text, "end_header", "end_header \t")).triangles == expected);
    CHECK(load(with(text, "ply\n", "ply \n")).triangles == expected);
    const std::string header =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    CHECK(load(header + "+0 0 0\n+1 0 -0\n1 +1e+0 1e-999\n3 0 +1 2\n").triangles == expected);
    // Rows that are longer than the header says; an item that spans lines; all in one line.
    const Mesh longer = load(header + "0 0 0 255 0\n1 0 0 255 0\n\n1 1 0 9\n3 0 1 2 0.5 0.5\n");
    CHECK(longer.triangles == expected);
    CHECK(longer.vertices == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}});
    CHECK(load(header + "0 0\n0\n1 0 0\n1 1 0\n3 0\n1 2\n").triangles == expected);
    CHECK(load(header + "0 0 0 1 0 0 1 1 0 3 0 1 2").triangles == expected);
}

TEST_CASE("a negative PLY list length is refused") {
    PlyText ply("binary_little_endian",
                "element vertex 0\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
                "property list char int vertex_indices\n");
    expect_io_error(ply.put(std::int8_t{-3}).put(std::int32_t{0}).text(), {"face 0", "a list of -3 entries"});
}

TEST_CASE("words in an ASCII PLY file's body are reported with their line") {
    const std::string header =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    CHECK(load(header + "0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n").triangles.size() == 1);
    expect_io_error(header + "0 0 0\n1 abc 0\n1 1 0\n3 0 1 2\n", {"vertex 1 (line 11)", "\"abc\" is not a number"});
    expect_io_error(header + "0 0 0\n1 0 0\n1 1 0\n3 0 1 1.5\n", {"face 0 (line 13)", "vertex 1.5"});
    expect_io_error(header + "0 0 0\n1 0 0\n1 1 0\n3 0 1      ", {"face 0 (line 13)", "the file ends here"});
}

TEST_CASE("malformed PLY headers are reported with their line") {
    const std::string text = plain_ply("binary_little_endian", kCorners, {{0, 1, 2}});
    expect_io_error("", {"line 1", "not a PLY file"});
    expect_io_error("plyx\n", {"line 1", "not a PLY file"});
    expect_io_error("ply\nformat ascii 1.0\nelement vertex 1\n", {"line 4", "no end"});
    expect_io_error(with(text, "binary_little_endian 1.0", "binary 1.0"), {"line 2", "unknown format \"binary\""});
    expect_io_error(with(text, "1.0", "2.0"), {"line 2", "\"2.0\""});
    expect_io_error(with(text, "format ", "fmt "), {"line 2", "expected \"format"});
    expect_io_error(with(text, "vertex 4", "vertex four"), {"line 3", "\"four\" is not a count"});
    expect_io_error(with(text, "vertex 4", "vertex -4"), {"line 3", "\"-4\" is not a count"});
    expect_io_error(with(text, "vertex 4", "vertex"), {"line 3", "expected \"element"});
    expect_io_error(with(text, "element face", "element vertex"), {"line 7", "a second element \"vertex\""});
    expect_io_error(with(text, "property float y", "property real y"), {"line 5", "unknown type \"real\""});
    expect_io_error(with(text, "property float y", "property float"), {"line 5", "expected \"property"});
    expect_io_error(with(text, "property float y", "texture y"), {"line 5", "unknown keyword \"texture\""});
    expect_io_error(with(text, "list uchar", "list float"), {"line 8", "must be an integer"});
    expect_io_error(with(text, "element vertex 4\n", ""), {"line 3", "before the first element"});
    expect_io_error(with(text, "property list uchar int vertex_indices\n", ""), {"\"face\" has no property"});
}

TEST_CASE("PLY headers without the needed elements are refused") {
    const std::string text = plain_ply("binary_little_endian", kCorners, {{0, 1, 2}});
    expect_io_error(with(text, "property float y", "property float up"), {"no property \"y\""});
    expect_io_error(with(text, "element vertex", "element point"), {"no element \"vertex\""});
    expect_io_error(with(text, "element face", "element strip"), {"no element \"face\" or \"tristrips\""});
    expect_io_error(with(text, "vertex_indices", "corners"), {"no list \"vertex_indices\""});
    expect_io_error(with(text, "uchar int vertex", "uchar float vertex"), {"no list \"vertex_indices\""});
    expect_io_error(
        "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\nelement vertex 3\n"
        "property float x\nproperty float y\nproperty float z\nend_header\n3 0 1 2\n0 0 0 1 0 0 1 1 0\n",
        {"before element \"vertex\""});
}

TEST_CASE("a PLY header may have empty lines, lines that end with CR alone, and elements of nothing") {
    std::string text =
        with(plain_ply("ascii", kCorners, {{0, 1, 2}}), "element vertex", "\nelement none 0\nelement vertex");
    CHECK(load(text).triangles.size() == 1);
    std::ranges::replace(text, '\n', '\r');
    CHECK(load(text).vertices == kCorners);
}
