#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "clbvh/io/scene.hpp"
#include "io/temp_folder.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr std::string_view kStl =
    "solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 0 0 1\nendloop\nendfacet\nendsolid one\n";

/// A triangle (0,0,0) (1,0,0) (0,1,0), once moved by (10, 0, 0) and doubled, once only moved; and its points.
std::string gltf(const std::string& buffer) {
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
        "nodes":[{"translation":[10,0,0],"children":[1,2]},{"mesh":0,"scale":[2,2,2]},{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}},{"attributes":{"POSITION":0},"mode":0}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
        "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36)" +
           buffer + "}]}";
}

const std::string kEmbedded =
    R"(,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA")";

template <typename T>
std::string bytes_of(const T& value) {
    return {reinterpret_cast<const char*>(&value), sizeof value};
}

std::string glb_chunk(std::string_view type, std::string data) {
    while (data.size() % 4 != 0)
        data += ' ';
    return bytes_of(static_cast<std::uint32_t>(data.size())) + std::string(type) + data;
}

std::string glb() {
    const std::array<float, 9> positions{0, 0, 0, 1, 0, 0, 0, 1, 0};
    const std::string chunks = glb_chunk("JSON", gltf("")) + glb_chunk({"BIN\0", 4}, bytes_of(positions));
    return "glTF" + bytes_of(std::uint32_t{2}) + bytes_of(static_cast<std::uint32_t>(12 + chunks.size())) + chunks;
}

/// The corners of all triangles, in order.
std::vector<Vec3> corners_of(const Mesh& mesh) {
    std::vector<Vec3> corners;
    for (const Triangle& triangle : mesh.triangles) {
        for (const std::uint32_t corner : triangle)
            corners.push_back(mesh.vertices.at(corner));
    }
    return corners;
}

bool without_assimp() {
    const TempFolder folder;
    const std::string path = folder.write("probe.stl", kStl);
    try {
        (void)load_scene(path);
        return false;
    } catch (const Error& error) {
        if (error.code() != ErrorCode::unsupported) return false;
        CHECK_THAT(error.what(), Catch::Contains(path) && Catch::Contains("install libassimp-dev"));
        WARN("SKIPPED: the library was configured without assimp");
        return true;
    }
}

Mesh load(const std::string& name, std::string_view content) {
    const TempFolder folder;
    return load_scene(folder.write(name, content));
}

}  // namespace

TEST_CASE("an STL file gives its triangles in order") {
    if (without_assimp()) return;
    const std::vector<Vec3> expected{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    CHECK(corners_of(load("mesh.stl", kStl)) == expected);

    std::string binary(80, '\0');
    binary += bytes_of(std::uint32_t{1}) + bytes_of(std::array<float, 12>{0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0});
    binary += std::string(2, '\0');
    CHECK(corners_of(load("mesh.STL", binary)) == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
}

TEST_CASE("glTF nodes are placed, and points dropped") {
    if (without_assimp()) return;
    const std::vector<Vec3> expected{{10, 0, 0}, {12, 0, 0}, {10, 2, 0}, {10, 0, 0}, {11, 0, 0}, {10, 1, 0}};
    CHECK(corners_of(load("scene.gltf", gltf(kEmbedded))) == expected);
    CHECK(corners_of(load("scene.glb", glb())) == expected);
}

TEST_CASE("polygons that come through assimp are triangulated") {
    if (without_assimp()) return;
    const Mesh mesh = load("mesh.off", "OFF\n5 1 0\n0 0 0\n2 0 0\n2 2 0\n1 0.5 0\n0 2 0\n5 0 1 2 3 4\n");
    CHECK(mesh.triangles.size() == 3);
}

TEST_CASE("a file that assimp cannot parse is reported with its reason") {
    if (without_assimp()) return;
    const TempFolder folder;
    const std::string broken = folder.write("broken.gltf", R"({"asset":{"version":"2.0"}})");
    expect_error(ErrorCode::io, {broken, "No scene"}, [&] { (void)load_scene(broken); });
    const std::string lost = folder.write("lost.gltf", gltf(R"(,"uri":"lost.bin")"));
    expect_error(ErrorCode::io, {lost, "lost.bin"}, [&] { (void)load_scene(lost); });
}

TEST_CASE("a format that nobody knows is unsupported") {
    const TempFolder folder;
    for (const std::string name : {"notes.unheard-of", "noextension"}) {
        const std::string path = folder.write(name, "text");
        expect_error(ErrorCode::unsupported, {path}, [&] { (void)load_scene(path); });
    }
}
