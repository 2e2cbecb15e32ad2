#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "clbvh/io/scene.hpp"
#include "io/temp_folder.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

Mesh load(const std::string& text) {
    const TempFolder folder;
    return load_scene(folder.write("mesh.obj", text));
}

void expect_io_error(const std::string& text, const std::string& line, const std::string& reason) {
    const TempFolder folder;
    const std::string path = folder.write("mesh.obj", text);
    INFO(text);
    expect_error(ErrorCode::io, {path, line, reason}, [&] { (void)load_scene(path); });
}

const std::string kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// An OBJ file with one polygon in a tilted plane, through points that come in the order of its corners.
std::string tilted_polygon(const std::vector<std::pair<double, double>>& points) {
    std::ostringstream text;
    for (const auto& [x, y] : points)
        text << "v " << x + 5 << ' ' << y - 3 << ' ' << 0.5 * x + 0.25 * y + 9 << '\n';
    text << 'f';
    for (std::size_t i = 1; i <= points.size(); ++i)
        text << ' ' << i;
    return text.str() + '\n';
}

/// The signed area of a triangle seen along z.
double area_from_above(const Mesh& mesh, const Triangle& t) {
    const Vec3& a = mesh.vertices[t[0]];
    const Vec3& b = mesh.vertices[t[1]];
    const Vec3& c = mesh.vertices[t[2]];
    return 0.5 * ((double{b.x} - a.x) * (double{c.y} - a.y) - (double{b.y} - a.y) * (double{c.x} - a.x));
}

/// A star with `spikes` spikes around the origin; its area is known.
std::vector<std::pair<double, double>> star(std::size_t spikes) {
    std::vector<std::pair<double, double>> points;
    for (std::size_t i = 0; i < 2 * spikes; ++i) {
        const double angle = M_PI * static_cast<double>(i) / static_cast<double>(spikes);
        const double radius = i % 2 == 0 ? 1.0 : 0.5;
        points.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
    }
    return points;
}

double star_area(std::size_t spikes) {
    return static_cast<double>(spikes) * 0.5 * std::sin(M_PI / static_cast<double>(spikes));
}

}  // namespace

TEST_CASE("an OBJ file's objects, groups and materials are merged in order") {
    const Mesh mesh = load("# four corners\nmtllib none.mtl\no first\n" + kSquare +
                           "vn 0 0 1\nvt 0 0\ng a b\nusemtl red\nf 1 2 3\no second\ng\nusemtl blue\ns off\n"
                           "f 1/1/1 3//1 4/1\n\tf\t2 3 4  \nl 1 2\np 1\n");
    CHECK(mesh.vertices == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
    CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {1, 2, 3}});
}

TEST_CASE("OBJ coordinates are rounded correctly and may carry weights or colours") {
    const Mesh mesh = load("v 0.1 -1e-3 +7\nv 1e-50 -.5 3. 0.25\nv 16777217 1e30 0 0.1 0.2 0.3\nf 1 2 3\n");
    CHECK(mesh.vertices == std::vector<Vec3>{{0.1f, -1e-3f, 7}, {0, -0.5f, 3}, {16777216, 1e30f, 0}});
}

TEST_CASE("an OBJ coordinate may be nan") {
    const Mesh mesh = load("v 0 nan 0\nv 1 0 -NaN\nv 1 1 0\nf 1 2 3\n");
    CHECK(std::isnan(mesh.vertices[0].y));
    CHECK(std::isnan(mesh.vertices[1].z));
    CHECK(mesh.vertices[2] == Vec3{1, 1, 0});
    CHECK(mesh.triangles.size() == 1);
}

TEST_CASE("OBJ lines may end in any way") {
    const std::vector<Triangle> expected{{0, 1, 2}};
    CHECK(load("v 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nf 1 2 3\r\n").triangles == expected);
    CHECK(load("v 0 0 0\rv 1 0 0\rv 1 1 0\rf 1 2 3\r").triangles == expected);
    CHECK(load("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3").triangles == expected);
}

TEST_CASE("OBJ indices may be relative or point forward") {
    CHECK(load(kSquare + "f -4 -3 -2\nv 5 5 5\nf -1 1 -2\n").triangles == std::vector<Triangle>{{0, 1, 2}, {4, 0, 3}});
    CHECK(load("f 1 2 3\ng late\nf 4 3 2 1\n" + kSquare).triangles.size() == 3);
}

TEST_CASE("an OBJ file without faces is an empty mesh") {
    CHECK(load("").triangles.empty());
    CHECK(load(kSquare).triangles.empty());
}

TEST_CASE("OBJ polygons of any size are cut into as many triangles as they have corners less two") {
    // 300 corners are more than a byte counts.
    for (const std::size_t spikes : {2u, 3u, 5u, 150u, 1200u}) {
        const Mesh mesh = load(tilted_polygon(star(spikes)));
        CHECK(mesh.triangles.size() == 2 * spikes - 2);
    }
}

TEST_CASE("concave OBJ polygons keep their area and winding") {
    for (const bool reversed : {false, true}) {
        for (const std::size_t spikes : {3u, 4u, 5u, 12u, 100u}) {
            std::vector<std::pair<double, double>> points = star(spikes);
            if (reversed) std::reverse(points.begin(), points.end());
            const Mesh mesh = load(tilted_polygon(points));
            double area = 0.0;
            int turned = 0;
            for (const Triangle& triangle : mesh.triangles) {
                const double part = area_from_above(mesh, triangle);
                area += std::abs(part);
                turned += (part < 0) != reversed;
            }
            INFO(spikes << " spikes, reversed " << reversed);
            CHECK(area == Approx(star_area(spikes)).epsilon(1e-4));
            CHECK(turned == 0);
        }
    }
}

TEST_CASE("a self-intersecting OBJ polygon is still cut into triangles") {
    CHECK(load("v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nv 0.5 3 0\nf 1 2 3 4 5\n").triangles.size() == 3);
    CHECK(load("v 0 0 0\nf 1 1 1 1 1\n").triangles.size() == 3);
    CHECK(load("v nan 0 0\n" + kSquare + "f 1 2 3 4 5\n").triangles.size() == 3);
}

TEST_CASE("malformed OBJ vertices are reported with their line") {
    expect_io_error(kSquare + "v 1 abc 3\n", "line 5", "\"abc\" is not a coordinate");
    expect_io_error("# one\n\nv 1 2\n", "line 3", "three coordinates");
    expect_io_error("v\n", "line 1", "three coordinates");
    expect_io_error("v 1 2 3x\n", "line 1", "\"3x\"");
    expect_io_error("v 1,5 2 3\n", "line 1", "\"1,5\"");
    expect_io_error("v 0x10 2 3\n", "line 1", "\"0x10\"");
    expect_io_error("v 1 2 1e400\n", "line 1", "\"1e400\"");
    expect_io_error("v 1 2 +-3\n", "line 1", "\"+-3\"");
    expect_io_error("v 0 0 0\r\nv 1 0 0\rv 1 - 0\n", "line 3", "\"-\"");
}

TEST_CASE("malformed OBJ faces are reported with their line") {
    expect_io_error(kSquare + "f a b c\n", "line 5", "\"a\" is not a corner");
    expect_io_error(kSquare + "f 1 2 0\n", "line 5", "\"0\"");
    expect_io_error(kSquare + "f 1 2 3.5\n", "line 5", "\"3.5\"");
    expect_io_error(kSquare + "f 1/1/1/ 2 3\n", "line 5", "\"1/1/1/\"");
    expect_io_error(kSquare + "f 1/x/1 2 3\n", "line 5", "\"1/x/1\"");
    expect_io_error(kSquare + "f 1//1/1 2 3\n", "line 5", "\"1//1/1\"");
    expect_io_error(kSquare + "f 1 2 99999999999\n", "line 5", "\"99999999999\"");
}

TEST_CASE("OBJ faces of fewer than three corners are skipped and counted, as are points and lines") {
    const TempFolder folder;
    const std::string path = folder.write("few.obj", kSquare + "f 1 2\nf\nf 1\nf 1 2 3\nl 1 2\np 4\nf 1 2 3 4\n");
    LoadReport report;
    const Mesh mesh = load_scene(path, {{}, &report});
    CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}});
    CHECK(report.faces == 5);
    CHECK(report.skipped_faces == 3);
    CHECK(report.points_and_lines == 2);
    expect_io_error(kSquare + "f 1 2\nf 9 1\n", "line 6", "vertex 9 does not exist");
}

TEST_CASE("OBJ files are read as other programs write them") {
    const std::vector<Triangle> expected{{0, 1, 2}};
    const std::string corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\n";
    CHECK(load("\xEF\xBB\xBF" + corners + "f 1 2 3\n").vertices.size() == 3);
    CHECK(load(corners + "f 1 2 3 # a face\n").triangles == expected);
    CHECK(load("v 0 0 0# a vertex\nv 1 0 0\nv 1 1 0\nf 1 2 3\n").triangles == expected);
    for (const std::string face : {"f 1/ 2/ 3/", "f 1/1/ 2/2/ 3/3/", "f 1// 2// 3//", "f 1/0/0 2/-9/7 3", "fo 1 2 3"})
        CHECK(load(corners + face + "\n").triangles == expected);
    for (const std::string end : {"\n", "\r\n"}) {
        const std::string next = "\\" + end;
        CHECK(load("v 0 0" + next + " 0" + end + "v 1 " + next + next + "0 0" + end + "v 1 1 0" + end + "f 1 2" + next +
                   "3" + end)
                  .triangles == expected);
    }
    CHECK(load(corners + "f 1 2 3\\").triangles == expected);
    // A number that nobody needs may be any; the line behind a continued one is counted.
    CHECK(load("v 0 0 0 1e2147483648\nv 1 0 0\nv 1 1 0\nvt 1e2147483648 0\nf 1 2 3\n").triangles == expected);
    expect_io_error(corners + "f 1 \\\n2 3\nf 1 2 x\n", "line 6", "\"x\"");
    expect_io_error("\xFF\xFEv", "mesh.obj", "UTF-16");
}

TEST_CASE("OBJ indices out of range are reported with their line") {
    expect_io_error(kSquare + "f 1 2 99\n", "line 5", "vertex 99 does not exist");
    expect_io_error(kSquare + "f 1 2 5\nf 1 2 99\nf 1 2 98\nv 5 5 5\n", "line 6", "vertex 99");
    expect_io_error("v 0 0 0\nv 1 0 0\nv 1 1 0\nf -4 2 3\nv 0 0 0\n", "line 4", "vertex -4 does not exist");
}

TEST_CASE("a binary file is no OBJ file") {
    const TempFolder folder;
    const std::string path = folder.write("mesh.obj", std::string_view("v 0 0 0\n\0\1\2", 11));
    expect_error(ErrorCode::io, {path, "not an OBJ file"}, [&] { (void)load_scene(path); });
}

TEST_CASE("a backslash at the end of an OBJ comment continues nothing") {
    const std::vector<Triangle> expected{{0, 1, 2}};
    const Mesh mesh = load("# C:\\scenes\\\nv 0 0 0\nv 1 0 0 # D:\\\nv 1 1 0\nf 1 2 3 # \\\n");
    CHECK(mesh.vertices == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}});
    CHECK(mesh.triangles == expected);
    // Blanks may follow one that does.
    CHECK(load("v 0 0 \\ \t\n0\nv 1 0 0\nv 1 1 0\nf 1 \\  \r\n2 3").triangles == expected);
}

TEST_CASE("OBJ indices may have plus signs, and those that are not needed any size") {
    CHECK(load(kSquare + "f +1 +2 +3\n").triangles == std::vector<Triangle>{{0, 1, 2}});
    CHECK(load(kSquare + "f 1/99999999999/0 2//+4294967296 3/-2147483649\n").triangles.size() == 1);
    expect_io_error(kSquare + "f 1/+ 2 3\n", "line 5", "\"1/+\"");
    expect_io_error(kSquare + "f 1 2 +-3\n", "line 5", "\"+-3\"");
}
