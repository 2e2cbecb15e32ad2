#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "io/read/read_file.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

Mesh load(const std::string& text, LoadReport* report = nullptr) {
    return load_text("mesh.STL", text, report);
}

void expect_io_error(const std::string& text, const std::vector<std::string>& parts) {
    expect_refused(ErrorCode::io, "mesh.stl", text, parts);
}

std::string facet(const std::string& a, const std::string& b, const std::string& c) {
    return "facet normal 0 0 1\n outer loop\n  vertex " + a + "\n  vertex " + b + "\n  vertex " + c +
           "\n endloop\nendfacet\n";
}

/// A binary file of `count` triangles; corner k of triangle i is (i, k, 0.5).
std::string binary(std::string header, std::uint32_t count) {
    header.resize(80, ' ');
    std::string text = header + bytes_of(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto x = static_cast<float>(i);
        text += bytes_of(std::array<float, 12>{0, 0, 1, x, 0, 0.5f, x, 1, 0.5f, x, 2, 0.5f}) + std::string(2, '\0');
    }
    return text;
}

}  // namespace

TEST_CASE("an ASCII STL file gives its triangles in order") {
    const std::string first = facet("0 0 0", "1 0 0", "0 1 0"), second = facet("0 0 0", "+1e0 2.5 0", "0 1 -1E-3");
    const std::vector<Vec3> expected{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {1, 2.5f, 0}, {0, 1, -1e-3f}};
    LoadReport report;
    CHECK(corners_of(load("solid a part of \"facet\" 1\n" + first + second + "endsolid a part\n", &report)) ==
          expected);
    CHECK(report.meshes == 1);
    CHECK(corners_of(load("solid\n" + first + "endsolid\n\nsolid two\n" + second + "endsolid two", &report)) ==
          expected);
    CHECK(report.meshes == 2);
    CHECK(corners_of(load("\xEF\xBB\xBF  SOLID X\r\nFACET NORMAL nan nan nan\r\nOUTER LOOP\r\nVERTEX 0 0 0\r\n"
                          "VERTEX 1 0 0\r\nVERTEX 0 1 0\r\nENDLOOP\r\nENDFACET\r\nENDSOLID X\r\n" +
                          second)) == expected);
    CHECK(load("solid nothing\nendsolid nothing\n").triangles.empty());
}

TEST_CASE("a binary STL file is told from an ASCII one by more than its first word") {
    for (const std::uint32_t count : {0U, 1U, 12U}) {
        for (const std::string header : {"made by X", "solid base", "", "Solid\nfacet"}) {
            for (const std::string behind : {"", "\n", "bytes behind the end"}) {
                INFO(count << " triangles, header \"" << header << "\", behind them \"" << behind << '"');
                const Mesh mesh = load(binary(header, count) + behind);
                REQUIRE(mesh.triangles.size() == count);
                if (count > 0) CHECK(mesh.vertices[mesh.triangles.back()[2]] == Vec3{float(count - 1), 2, 0.5f});
            }
        }
    }
}

TEST_CASE("STL polygons are cut into triangles, and what is less is skipped and counted") {
    LoadReport report;
    const std::string quad =
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\n"
        "endloop\nendfacet\n";
    const std::string two = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet\n";
    CHECK(load("solid\n" + quad + two + "endsolid\n", &report).triangles.size() == 2);
    CHECK(report.skipped_faces == 1);
}

TEST_CASE("malformed STL files are reported with their line, or what is missing") {
    const std::string good = facet("0 0 0", "1 0 0", "0 1 0");
    expect_io_error("solid\n" + facet("0 0 0", "1 zero 0", "0 1 0"), {"line 5", "\"zero\" is not a coordinate"});
    expect_io_error("solid\n" + facet("0 0 0", "1 0", "0 1 0"), {"line 5", "three coordinates"});
    expect_io_error("solid\n" + good + "face\n", {"line 9", "\"face\" is no keyword"});
    expect_io_error("solid\nvertex 0 0 0\n", {"line 2", "outside a facet"});
    expect_io_error("solid\nfacet normal 0 0 1\nfacet normal 0 0 1\n", {"line 3", "within a facet"});
    expect_io_error("solid\nfacet normal 0 0 1\nouter loop\n", {"the file ends within a facet"});
    expect_io_error("solid\nendfacet\n", {"line 2", "without a facet"});
    expect_io_error("", {"neither ASCII STL"});
    expect_io_error("stl", {"has 84 bytes: this file has 3"});
    const std::string text = binary("X", 3);
    for (std::size_t size = 84; size < text.size(); size += 7)
        expect_io_error(text.substr(0, size), {"promises 3 triangles", "is it truncated?"});
}

TEST_CASE("an ASCII STL facet may stand in one line") {
    const Mesh mesh = load(
        "solid\nfacet normal x y z outer loop vertex 0 0 0 vertex 1 0 0\nvertex 0 1 0 endloop endfacet\n"
        "facet outer loop vertex 0 0 0 vertex 0 1 0 vertex 0 0 1 endloop endfacet endsolid\n");
    CHECK(corners_of(mesh) == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 1, 0}, {0, 0, 1}});
}
