#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "clbvh/core/error.hpp"
#include "io/read/gltf.hpp"
#include "io/read/mesh_sink.hpp"
#include "io/read/obj.hpp"
#include "io/read/off.hpp"
#include "io/read/ply.hpp"
#include "io/read/stl.hpp"

using namespace clbvh;
using namespace clbvh::io;

namespace {

using Reader = void (*)(std::string_view text, MeshSink& sink);

/// Reads the text, whatever it is. Whether a mesh came of it, whose indices are in range, or an Error.
bool is_read_or_refused(Reader reader, const std::string& text) {
    MeshSink sink("file", text.size(), {});
    try {
        reader(text, sink);
    } catch (const Error&) {
        return true;
    }
    return std::ranges::all_of(sink.mesh.triangles, [&](const Triangle& triangle) {
        return std::ranges::all_of(triangle, [&](std::uint32_t index) { return index < sink.mesh.vertices.size(); });
    });
}

/// Changes some bytes: to any, to those of another place, or to numbers that are large, negative, or none.
class Damage {
public:
    explicit Damage(unsigned seed) : random_(seed) {}

    std::string of(std::string text) {
        for (std::size_t changes = 1 + below(4); changes > 0 && !text.empty(); --changes)
            change(text);
        return text;
    }

private:
    std::size_t below(std::size_t end) { return std::uniform_int_distribution<std::size_t>(0, end - 1)(random_); }

    void change(std::string& text) {
        static const std::vector<std::string> kWords{
            "-1", "99", "4294967295",         "1e999",           "nan", "-", "/", "\n", "\\\n", "#", "[", "]",
            "{",  "\"", std::string(1, '\0'), "\xFF\xFF\xFF\xFF"};
        const std::size_t place = below(text.size()), length = 1 + below(8);
        switch (below(5)) {
            case 0: text[place] = static_cast<char>(below(256)); break;
            case 1: text.erase(place, length); break;
            case 2: text.insert(place, text.substr(below(text.size()), 4 * length)); break;
            case 3: text.replace(place, length % 3, kWords[below(kWords.size())]); break;
            default: text.resize(place); break;
        }
    }

    std::mt19937 random_;
};

void check_damaged(Reader reader, const std::vector<std::string>& files) {
    Damage damage(11);
    int faults = 0;
    for (int round = 0; round < 20000; ++round) {
        const std::string text = damage.of(files[static_cast<std::size_t>(round) % files.size()]);
        if (is_read_or_refused(reader, text)) continue;
        UNSCOPED_INFO("read into a mesh with an index out of range: " << text);
        ++faults;
    }
    CHECK(faults == 0);
}

const std::string kPlyHeader =
    "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n"
    "property list uchar int vertex_indices\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n";
const std::string kPoints = "0 0 0\n2 0 0\n2 2 0\n1 0.5 0\n0 2 0\n";

std::string binary_ply() {
    std::string text = kPlyHeader;
    text.replace(text.find("ascii"), 5, "binary_little_endian");
    text += std::string(60, '\1') + '\3' + std::string("\0\0\0\0\1\0\0\0\2\0\0\0", 12) + '\3' +
            std::string("\4\0\0\0\3\0\0\0\2\0\0\0", 12) + std::string("\3\0\0\0\0\0\0\0\1\0\0\0\2\0\0\0", 16);
    return text;
}

std::string binary_stl() {
    std::string text(80, 's');
    text += std::string("\2\0\0\0", 4) + std::string(100, '\2');
    return text;
}

/// With a sparse accessor, a morph target, a skin, instances and a strip.
const std::string kGltf = R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":48,"uri":"data:;base64,)"
                          R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAABAAIAAAAAAAAA"}],)"
                          R"("bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":8}],)"
                          R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},)"
                          R"({"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"},)"
                          R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","sparse":{"count":1,)"
                          R"("indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":0}}}],)"
                          R"("meshes":[{"weights":[0.5],"primitives":[{"attributes":{"POSITION":0},"indices":1,)"
                          R"("targets":[{"POSITION":2}]},{"mode":5,"attributes":{"POSITION":2}}]}],"scene":0,)"
                          R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"children":[1],"scale":[1,2,3]},{"mesh":0,)"
                          R"("extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":0}}}}]})";

void read_gltf_alone(std::string_view text, MeshSink& sink) {
    read_gltf(text, "no-such-folder", sink);
}

}  // namespace

TEST_CASE("damaged OBJ files are read or refused") {
    check_damaged(read_obj,
                  {"v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 0.5 0\nv 0 2 0\nvt 0 0\nf 1/1/1 2//1 3/1 4 5\nf -1 -2 \\\n-3\n",
                   "o a\nf 1 2 3\nv 0 0 0\nv 1 0 0\nv 1 1 0\nl 1 2\nf 3 2 1 # c\n"});
}

TEST_CASE("damaged PLY files are read or refused") {
    check_damaged(read_ply, {kPlyHeader + kPoints + "5 0 1 2 3 4\n3 0 1 2\n6 0 1 2 -1 3 4\n", binary_ply()});
}

TEST_CASE("damaged STL files are read or refused") {
    const std::string facet =
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    check_damaged(read_stl, {"solid a\n" + facet + facet + "endsolid a\n", binary_stl()});
}

TEST_CASE("damaged OFF files are read or refused") {
    check_damaged(read_off,
                  {"OFF\n5 2 0\n" + kPoints + "5 0 1 2 3 4\n3 0 1 2 255 0 0\n", "4OFF\n1 1 0\n1 2 3 4\n1 0\n"});
}

TEST_CASE("damaged glTF files are read or refused") {
    MeshSink sink("file", kGltf.size(), {});
    read_gltf_alone(kGltf, sink);
    REQUIRE(sink.mesh.triangles.size() == 8);
    check_damaged(read_gltf_alone, {kGltf});
}
