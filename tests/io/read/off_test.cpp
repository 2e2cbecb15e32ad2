#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "io/read/read_file.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

Mesh load(const std::string& text, LoadReport* report = nullptr) {
    return load_text("mesh.off", text, report);
}

void expect_failure(ErrorCode code, const std::string& text, const std::vector<std::string>& parts) {
    expect_refused(code, "mesh.off", text, parts);
}

const std::string kSquare = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
const std::vector<Triangle> kTwo{{0, 1, 2}, {0, 2, 3}};

}  // namespace

TEST_CASE("OFF files are read as programs write them") {
    CHECK(load("OFF\n4 1 0\n" + kSquare + "4 0 1 2 3\n").triangles == kTwo);
    CHECK(load("OFF 4 1 0\n" + kSquare + "4 0 1 2 3\n").triangles == kTwo);
    CHECK(load("4 1 4\r\n0 0 0\r\n1 0 0\r\n1 1 0\r\n0 1 0\r\n4 0 1 2 3").triangles == kTwo);
    CHECK(load("\xEF\xBB\xBFOFF # name\n# a comment\n\n4 2 # no edges\n" + kSquare +
               "\n3 0 1 2 # first\n# between\n\n3 0 2 3 255 0 0\n")
              .triangles == kTwo);
    const Mesh numbers = load("OFF\n3 1 0\n+1 -2e0 .5\n1e-999 0 0\n0 1. 0\n3 0 1 2\n");
    CHECK(numbers.vertices == std::vector<Vec3>{{1, -2, 0.5f}, {0, 0, 0}, {0, 1, 0}});
}

TEST_CASE("what OFF variants have beside coordinates is skipped") {
    CHECK(load("COFF\n4 1 0\n0 0 0 255 0 0 255\n1 0 0 1 1 1 1\n1 1 0 0 0 0 0\n0 1 0 0 0 0 0\n4 0 1 2 3\n").triangles ==
          kTwo);
    CHECK(
        load("STCNOFF\n4 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n0 1 0 0 0 1\n4 0 1 2 3 0.5 0.5 0.5\n").triangles ==
        kTwo);
    CHECK(load("4OFF\n3 1 0\n2 0 0 2\n0 3 0 1\n0 0 1 -1\n3 0 1 2\n").vertices ==
          std::vector<Vec3>{{1, 0, 0}, {0, 3, 0}, {0, 0, -1}});
    expect_failure(ErrorCode::unsupported, "nOFF\n3\n3 1 0\n", {"nOFF"});
    expect_failure(ErrorCode::unsupported, "OFF BINARY\n", {"binary OFF"});
}

TEST_CASE("OFF faces may have any number of corners, in lines of any length") {
    for (const int corners : {10, 1200, 20000}) {
        std::string text = "OFF\n" + std::to_string(corners) + " 1 0\n", face = std::to_string(corners);
        for (int i = 0; i < corners; ++i) {
            const double angle = 2 * M_PI * i / corners;
            text += std::to_string(std::cos(angle)) + ' ' + std::to_string(std::sin(angle)) + " 0\n";
            face += ' ' + std::to_string(i);
        }
        CHECK(load(text + face + '\n').triangles.size() == static_cast<std::size_t>(corners - 2));
    }
    LoadReport report;
    CHECK(load("OFF\n4 4 0\n" + kSquare + "0\n1 2\n2 0 1\n4 0 1 2 3\n", &report).triangles == kTwo);
    CHECK(report.faces == 4);
    CHECK(report.skipped_faces == 3);
}

TEST_CASE("malformed OFF files are reported with their line") {
    const auto expect_io = [](const std::string& text, const std::vector<std::string>& parts) {
        expect_failure(ErrorCode::io, text, parts);
    };
    expect_io("", {"the file ends before the header"});
    expect_io("ply\n", {"line 1", "not an OFF file"});
    expect_io("XOFF\n", {"line 1", "\"XOFF\" is no variant"});
    expect_io("OFF\n", {"the file ends before the counts"});
    expect_io("OFF\n4 x\n", {"line 2", "\"x\" is not a count of faces"});
    expect_io("OFF\n-4 1\n", {"line 2", "\"-4\" is not a count of vertices"});
    expect_io("OFF\n4000000000 1 0\n0 0 0\n", {"line 2", "promises 4000000000 vertices", "truncated"});
    expect_io("OFF\n4 1 0\n0 0 0\n1 0\n", {"line 4", "vertex 1 needs more"});
    expect_io("OFF\n4 1 0\n0 0 0\n1 0 east\n", {"line 4", "\"east\" is not a coordinate"});
    expect_io("OFF\n4 2 0\n" + kSquare + "3 0 1 2\n", {"the file ends before face 1 of 2"});
    expect_io("OFF\n4 1 0\n" + kSquare + "3 0 1 4\n", {"line 7", "vertex 4 does not exist", "has 4"});
    expect_io("OFF\n4 1 0\n" + kSquare + "3 0 1 -1\n", {"line 7", "vertex -1 does not exist"});
    expect_io("OFF\n4 1 0\n" + kSquare + "5 0 1 2\n", {"line 7", "a face of 5 corners has 3"});
    expect_io("OFF\n4 1 0\n" + kSquare + "three 0 1 2\n", {"line 7", "\"three\" is not a count of corners"});
}

TEST_CASE("an OFF vertex that lies infinitely far is refused") {
    expect_failure(ErrorCode::io, "4OFF\n3 1 0\n2 0 0 2\n0 3 0 0\n0 0 1 1\n3 0 1 2\n",
                   {"line 4", "vertex 1", "infinitely"});
}
