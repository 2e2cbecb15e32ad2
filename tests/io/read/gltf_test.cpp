#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "io/read/read_file.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

std::string base64(const std::string& bytes) {
    constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t word = 0;
        for (std::size_t k = 0; k < 3; ++k)
            word = word << 8U | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
        for (std::size_t k = 0; k < 4; ++k)
            text += i + k <= bytes.size() ? kDigits[word >> (18 - 6 * k) & 63U] : '=';
    }
    return text;
}

/// A file that grows by arrays in one buffer, a view and an accessor each.
class Gltf {
public:
    template <typename T, std::size_t Size>
    int add(const std::string& type, int component, const std::array<T, Size>& values, std::size_t components,
            const std::string& more = "") {
        const std::string data = bytes_of(values);
        views_ += comma(views_) + R"({"buffer":0,"byteOffset":)" + std::to_string(bytes_.size()) + R"(,"byteLength":)" +
                  std::to_string(data.size()) + "}";
        accessors_ += comma(accessors_) + R"({"bufferView":)" + std::to_string(count_) + R"(,"componentType":)" +
                      std::to_string(component) + R"(,"count":)" + std::to_string(Size / components) + R"(,"type":")" +
                      type + '"' + more + "}";
        bytes_ += data;
        return count_++;
    }
    int add_accessor(const std::string& accessor) {
        accessors_ += comma(accessors_) + accessor;
        return count_++;
    }

    /// The JSON, with these members beside its arrays; `uri` is that of the buffer.
    [[nodiscard]] std::string json(const std::string& members, const std::string& uri) const {
        return R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":)" + std::to_string(bytes_.size()) + uri +
               R"(}],"bufferViews":[)" + views_ + R"(],"accessors":[)" + accessors_ + "]," + members + "}";
    }
    [[nodiscard]] std::string embedded(const std::string& members) const {
        return json(members, R"(,"uri":"data:application/octet-stream;base64,)" + base64(bytes_) + '"');
    }
    [[nodiscard]] const std::string& bytes() const { return bytes_; }

private:
    static std::string comma(const std::string& list) { return list.empty() ? "" : ","; }

    std::string bytes_, views_, accessors_;
    int count_ = 0;
};

constexpr int kByte = 5120, kShort = 5122, kUnsignedShort = 5123, kUnsigned = 5125, kFloat = 5126;

/// A square in the plane z = 0 as accessor 0, its two triangles as accessor 1.
Gltf square() {
    Gltf gltf;
    gltf.add("VEC3", kFloat, std::array<float, 12>{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, 3);
    gltf.add("SCALAR", kUnsignedShort, std::array<std::uint16_t, 6>{0, 1, 2, 0, 2, 3}, 1);
    return gltf;
}

std::string mesh(const std::string& primitive) {
    return R"("meshes":[{"primitives":[{"attributes":{"POSITION":0})" + primitive + "}]}]";
}

const std::string kShown = R"("scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)";

Mesh load(const std::string& text, LoadReport* report = nullptr, std::string_view name = "scene.gltf") {
    return load_text(name, text, report);
}

void expect_failure(ErrorCode code, const std::string& text, const std::vector<std::string>& parts) {
    expect_refused(code, "scene.gltf", text, parts);
}

const std::vector<Vec3> kSquare{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}};

}  // namespace

TEST_CASE("glTF buffers are read from base64, from files beside, and from GLB") {
    const Gltf gltf = square();
    const std::string members = kShown + mesh(R"(,"indices":1)");
    CHECK(corners_of(load(gltf.embedded(members))) == kSquare);
    CHECK(corners_of(load("\xEF\xBB\xBF" + gltf.embedded(members))) == kSquare);

    const TempFolder folder;
    (void)folder.write("my buffer.bin", gltf.bytes() + "more");
    CHECK(corners_of(load_scene(folder.write("a.GLTF", gltf.json(members, R"(,"uri":"./my%20buffer.bin")")))) ==
          kSquare);

    std::string json = gltf.json(members, "");
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const auto chunk = [](std::string_view type, const std::string& data) {
        return bytes_of(static_cast<std::uint32_t>(data.size())) + std::string(type) + data;
    };
    std::string glb = chunk("JSON", json) + chunk({"BIN\0", 4}, gltf.bytes()) + chunk("MORE", "1234");
    glb = "glTF" + bytes_of(std::uint32_t{2}) + bytes_of(static_cast<std::uint32_t>(12 + glb.size())) + glb;
    CHECK(corners_of(load(glb, nullptr, "scene.glb")) == kSquare);
    for (std::size_t size = 0; size < glb.size() - 12; size += 11) {
        const std::string path = folder.write("cut.glb", glb.substr(0, size));
        INFO("cut to " << size << " of " << glb.size());
        expect_error(ErrorCode::io, {path}, [&] { (void)load_scene(path); });
    }
}

TEST_CASE("glTF nodes are placed, by matrices and by parts, and meshes as often as they are shown") {
    const std::string nodes =
        R"("scene":1,"scenes":[{"nodes":[3]},{"nodes":[0,4]}],"nodes":[{"translation":[10,0,0],"children":[1,2]},)"
        R"({"mesh":0,"scale":[2,2,2]},{"mesh":0,"rotation":[0,0,0.7071067811865476,0.7071067811865476]},{"mesh":0},)"
        R"({"mesh":0,"matrix":[0,0,1,0, 1,0,0,0, 0,1,0,0, 0,0,5,1]}],)";
    LoadReport report;
    const Mesh loaded = load(square().embedded(nodes + mesh(R"(,"indices":1)")), &report);
    REQUIRE(loaded.triangles.size() == 6);
    CHECK(report.meshes == 1);
    CHECK(report.instances == 3);
    const std::vector<Vec3> corners = corners_of(loaded);
    const std::array<Vec3, 3> doubled{{{10, 0, 0}, {12, 0, 0}, {12, 2, 0}}},
        turned{{{10, 0, 0}, {10, 1, 0}, {9, 1, 0}}}, moved{{{0, 0, 5}, {0, 0, 6}, {1, 0, 6}}};
    for (std::size_t i = 0; i < 3; ++i) {
        CHECK(corners[i] == doubled[i]);
        CHECK(corners[6 + i].x == Approx(turned[i].x));
        CHECK(corners[6 + i].y == Approx(turned[i].y).margin(1e-6));
        CHECK(corners[12 + i] == moved[i]);
    }
    // Without scenes all roots are shown, without nodes all meshes.
    CHECK(load(square().embedded(R"("nodes":[{"mesh":0},{"mesh":0}],)" + mesh(R"(,"indices":1)"))).triangles.size() ==
          4);
    CHECK(load(square().embedded(mesh(R"(,"indices":1)"))).triangles.size() == 2);
    CHECK(load(R"({"asset":{"version":"2.0"}})").triangles.empty());
}

TEST_CASE("glTF strips, fans and lists without indices are triangles; points and lines are counted") {
    Gltf gltf = square();
    gltf.add("SCALAR", kUnsigned, std::array<std::uint32_t, 6>{0, 1, 3, 2, 2, 1}, 1);
    const auto triangles = [&](const std::string& primitive) {
        return load(gltf.embedded(kShown + mesh(primitive))).triangles;
    };
    CHECK(triangles(R"(,"mode":5,"indices":2)") == std::vector<Triangle>{{0, 1, 3}, {3, 1, 2}});
    CHECK(triangles(R"(,"mode":6)") == std::vector<Triangle>{{1, 2, 0}, {2, 3, 0}});
    CHECK(triangles(R"(,"mode":4,"indices":2)") == std::vector<Triangle>{{0, 1, 3}, {2, 2, 1}});
    LoadReport report;
    for (const char* mode : {"0", "1", "2", "3"})
        CHECK(load(gltf.embedded(kShown + mesh(std::string(R"(,"mode":)") + mode)), &report).triangles.empty());
    CHECK(report.points_and_lines == 1);
    expect_failure(ErrorCode::io, gltf.embedded(kShown + mesh("")), {"meshes[0].primitives[0]", "multiple of three"});
    expect_failure(ErrorCode::io, gltf.embedded(kShown + mesh(R"(,"mode":7)")), {"mode: 7 is none"});
}

TEST_CASE("glTF coordinates may be integers, normalised or not") {
    const std::string members =
        kShown + mesh(R"(,"indices":1)") +
        R"(,"extensionsUsed":["KHR_mesh_quantization"],"extensionsRequired":["KHR_mesh_quantization"])";
    const std::array<std::uint16_t, 3> indices{0, 1, 2};
    Gltf shorts;
    shorts.add("VEC3", kShort, std::array<std::int16_t, 9>{-32768, -32767, 0, 32767, 0, 0, 0, 32767, 0}, 3,
               R"(,"normalized":true)");
    shorts.add("SCALAR", kUnsignedShort, indices, 1);
    CHECK(load(shorts.embedded(members)).vertices == std::vector<Vec3>{{-1, -1, 0}, {1, 0, 0}, {0, 1, 0}});
    Gltf bytes;
    bytes.add("VEC3", kByte, std::array<std::int8_t, 9>{-128, 0, 0, 127, 0, 0, 0, 5, 0}, 3);
    bytes.add("SCALAR", kUnsignedShort, indices, 1);
    CHECK(load(bytes.embedded(members)).vertices == std::vector<Vec3>{{-128, 0, 0}, {127, 0, 0}, {0, 5, 0}});
}

TEST_CASE("glTF accessors may be sparse, and views interleaved") {
    Gltf gltf = square();
    gltf.add("SCALAR", kUnsignedShort, std::array<std::uint16_t, 2>{1, 3}, 1);
    gltf.add("VEC3", kFloat, std::array<float, 6>{7, 7, 7, 8, 8, 8}, 3);
    const std::string sparse =
        R"("sparse":{"count":2,"indices":{"bufferView":2,"componentType":5123},"values":{"bufferView":3}}})";
    gltf.add_accessor(R"({"bufferView":0,"componentType":5126,"count":4,"type":"VEC3",)" + sparse);
    gltf.add_accessor(R"({"componentType":5126,"count":4,"type":"VEC3",)" + sparse);
    const auto vertices = [&](int accessor) {
        return load(gltf.embedded(kShown + R"("meshes":[{"primitives":[{"mode":6,"attributes":{"POSITION":)" +
                                  std::to_string(accessor) + "}}]}]"))
            .vertices;
    };
    CHECK(vertices(4) == std::vector<Vec3>{{0, 0, 0}, {7, 7, 7}, {1, 1, 0}, {8, 8, 8}});
    CHECK(vertices(5) == std::vector<Vec3>{{0, 0, 0}, {7, 7, 7}, {0, 0, 0}, {8, 8, 8}});
    std::string text = gltf.embedded(kShown + mesh(R"(,"mode":6)"));
    text.replace(text.find(R"("byteLength":48})"), 16, R"("byteLength":48,"byteStride":16})");
    text.replace(text.find(R"("count":4)"), 9, R"("count":3)");
    CHECK(load(text).vertices == std::vector<Vec3>{{0, 0, 0}, {0, 0, 1}, {0, 0, 1}});
}

TEST_CASE("glTF primitives that share vertices share them in the mesh") {
    const Mesh loaded = load(square().embedded(
        kShown +
        R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1},{"attributes":{"POSITION":0},"mode":6}]}])"));
    CHECK(loaded.vertices.size() == 4);
    CHECK(loaded.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {1, 2, 0}, {2, 3, 0}});
}

TEST_CASE("glTF morph targets and skins are applied as the file says") {
    Gltf gltf = square();
    gltf.add("VEC3", kFloat, std::array<float, 12>{0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 4}, 3);
    gltf.add("VEC4", kUnsignedShort, std::array<std::uint16_t, 16>{0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0}, 4);
    gltf.add("VEC4", kFloat, std::array<float, 16>{1, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0, 1, 0, 0, 0}, 4);
    const std::string morphed =
        R"("meshes":[{"weights":[0.5],"primitives":[{"mode":6,"attributes":{"POSITION":0},"targets":[{"POSITION":2}]}]}])";
    CHECK(load(gltf.embedded(kShown + morphed)).vertices ==
          std::vector<Vec3>{{0, 0, 0.5f}, {1, 0, 0.5f}, {1, 1, 0.5f}, {0, 1, 2}});
    CHECK(load(gltf.embedded(R"("nodes":[{"mesh":0,"weights":[2]}],)" + morphed)).vertices[3] == Vec3{0, 1, 8});
    // Joint 1 stands at (0, 0, 10), and where the skinned node stands does not matter.
    const std::string skinned =
        R"("nodes":[{"mesh":0,"skin":0,"translation":[99,0,0]},{},{"translation":[0,0,10]}],"skins":[{"joints":[1,2]}],)"
        R"("meshes":[{"primitives":[{"mode":6,"attributes":{"POSITION":0,"JOINTS_0":3,"WEIGHTS_0":4}}]}])";
    CHECK(load(gltf.embedded(skinned)).vertices == std::vector<Vec3>{{0, 0, 0}, {1, 0, 10}, {1, 1, 5}, {0, 1, 0}});
    const std::string lost = R"("nodes":[{"mesh":0,"skin":0}],"skins":[{"joints":[0]}],)";
    expect_failure(ErrorCode::io, gltf.embedded(lost + mesh(R"(,"mode":6)")), {"has a skin, but it has no JOINTS_0"});
}

TEST_CASE("instances of EXT_mesh_gpu_instancing are placed") {
    Gltf gltf = square();
    gltf.add("VEC3", kFloat, std::array<float, 6>{0, 0, 1, 0, 0, 2}, 3);
    const std::string node =
        R"("nodes":[{"mesh":0,"scale":[1,1,10],"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":2}}}}],)";
    LoadReport report;
    const Mesh loaded =
        load(gltf.embedded(node + R"("extensionsRequired":["EXT_mesh_gpu_instancing"],)" + mesh(R"(,"indices":1)")),
             &report);
    CHECK(report.instances == 2);
    REQUIRE(loaded.vertices.size() == 8);
    CHECK(loaded.vertices[0] == Vec3{0, 0, 10});
    CHECK(loaded.vertices[4] == Vec3{0, 0, 20});
}

TEST_CASE("what a glTF file requires and nobody here knows is refused by name") {
    for (const std::string name : {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "ACME_anything"}) {
        expect_failure(
            ErrorCode::unsupported,
            square().embedded(kShown + R"("extensionsRequired":["KHR_materials_unlit",")" + name + "\"]," + mesh("")),
            {'"' + name + '"'});
    }
    CHECK(
        load(square().embedded(kShown + R"("extensionsRequired":["KHR_materials_unlit"],"extensionsUsed":["ACME_x"],)" +
                               mesh(R"(,"mode":6)")))
            .triangles.size() == 2);
}

TEST_CASE("a glTF file whose parts do not fit is refused with the place") {
    const auto expect_io = [](const std::string& text, const std::vector<std::string>& parts) {
        expect_failure(ErrorCode::io, text, parts);
    };
    Gltf gltf = square();
    gltf.add("SCALAR", kUnsignedShort, std::array<std::uint16_t, 3>{0, 1, 99}, 1);
    gltf.add_accessor(R"({"componentType":5126,"count":4,"type":"VEC3"})");
    gltf.add_accessor(R"({"bufferView":0,"componentType":5126,"count":5,"type":"VEC3"})");
    gltf.add_accessor(R"({"bufferView":0,"componentType":5126,"count":1e300,"type":"VEC3"})");
    gltf.add_accessor(R"({"bufferView":77,"componentType":5126,"count":4,"type":"VEC3"})");
    gltf.add_accessor(R"({"bufferView":0,"componentType":5124,"count":4,"type":"VEC3"})");
    const auto indices = [&](int accessor) {
        return gltf.embedded(kShown + mesh(R"(,"indices":)" + std::to_string(accessor)));
    };
    const auto positions = [&](int accessor) {
        return gltf.embedded(kShown + R"("meshes":[{"primitives":[{"attributes":{"POSITION":)" +
                             std::to_string(accessor) + "}}]}]");
    };
    expect_io(indices(2), {"meshes[0].primitives[0].indices", "element 2: vertex 99"});
    expect_io(indices(0), {"accessors[0] is of type \"VEC3\", not SCALAR"});
    expect_io(indices(50), {"accessors[50] does not exist; the file has 8"});
    expect_io(positions(3), {"accessors[3]", "no bufferView"});
    expect_io(positions(4), {"accessors[4]", "do not fit into bufferViews[0], which has 48 bytes"});
    expect_io(positions(5), {"accessors[5].count", "no whole number"});
    expect_io(positions(6), {"bufferViews[77] does not exist"});
    expect_io(positions(7), {"accessors[7].componentType: 5124 is none"});

    expect_io("", {"the JSON"});
    expect_io("[]", {"not a glTF file"});
    expect_io("{}", {"\"asset\" is missing"});
    expect_io(R"({"asset":{"version":"1.0"}})", {"only glTF 2"});
    expect_io(R"({"asset":{"version":"2.0"})", {"the JSON"});
    expect_io(R"({"asset":{"version":"2.0"},"nodes":{}})", {"nodes: it is of type object, not array"});
    expect_io(R"({"asset":{"version":"2.0"},"x":)" + std::string(200000, '[') + std::string(200000, ']') + "}",
              {"nested"});
    expect_io(R"({"asset":{"version":"2.0"},"nodes":[{"children":[1]},{"children":[0]}]})",
              {"nodes[0]: it is its own ancestor"});
    expect_io(R"({"asset":{"version":"2.0"},"nodes":[{"children":[2]},{"children":[2]},{}]})",
              {"nodes[2]: it is a child of nodes[0]"});
    expect_io(R"({"asset":{"version":"2.0"},"nodes":[{"children":[9]}]})",
              {"nodes[0].children: node 9 does not exist"});
    expect_io(R"({"asset":{"version":"2.0"},"nodes":[{"mesh":3}]})", {"meshes[3] does not exist"});
    expect_io(R"({"asset":{"version":"2.0"},"scene":4,"scenes":[{}]})", {"scenes[4] does not exist"});
}

TEST_CASE("a glTF file names buffers in its own folder or below, and nowhere else") {
    const TempFolder folder;
    const Gltf gltf = square();
    (void)folder.write("b.bin", gltf.bytes());
    for (const std::string uri : {"../b.bin", "/etc/passwd", "x/../../b.bin", "file:///etc/passwd", "http://x/b.bin",
                                  "%2e%2e/b.bin", "", "%00"}) {
        const std::string path = folder.write("a.gltf", gltf.json(kShown + mesh(""), R"(,"uri":")" + uri + '"'));
        INFO(uri);
        expect_error(ErrorCode::io, {path, "buffers[0].uri", "below the folder"}, [&] { (void)load_scene(path); });
    }
    const std::string lost = folder.write("lost.gltf", gltf.json(kShown + mesh(""), R"(,"uri":"lost.bin")"));
    expect_error(ErrorCode::io, {lost, "buffers[0].uri", "lost.bin"}, [&] { (void)load_scene(lost); });
    const std::string broken =
        folder.write("broken.gltf", gltf.json(kShown + mesh(""), R"(,"uri":"data:;base64,A?=")"));
    expect_error(ErrorCode::io, {broken, "no data in base64"}, [&] { (void)load_scene(broken); });
}

TEST_CASE("a chain of many glTF nodes is gone along") {
    std::string nodes;
    for (int i = 1; i <= 20000; ++i)
        nodes += R"({"translation":[1,0,0],"children":[)" + std::to_string(i) + "]},";
    const Mesh loaded = load(square().embedded(R"("nodes":[)" + nodes + R"({"mesh":0}],)" + mesh(R"(,"indices":1)")));
    REQUIRE(loaded.triangles.size() == 2);
    CHECK(loaded.vertices[0] == Vec3{20000, 0, 0});
}

TEST_CASE("triangles that a glTF node mirrors keep their front outside, and rotations need not be of length one") {
    const std::string mirrored = R"("nodes":[{"mesh":0,"scale":[-1,1,1]}],)",
                      far = R"("nodes":[{"mesh":0,"rotation":[0,0,9,0]}],)";
    const std::vector<Vec3> corners = corners_of(load(square().embedded(mirrored + mesh(R"(,"indices":1)"))));
    CHECK(std::vector<Vec3>(corners.begin(), corners.begin() + 3) ==
          std::vector<Vec3>{{0, 0, 0}, {-1, 1, 0}, {-1, 0, 0}});
    CHECK(load(square().embedded(far + mesh(R"(,"indices":1)"))).vertices[2] == Vec3{-1, -1, 0});
}

TEST_CASE("instances beyond the limit of memory are refused before they are made") {
    std::string nodes = R"("nodes":[{"mesh":0})";
    for (int i = 0; i < 999; ++i)
        nodes += R"(,{"mesh":0})";
    const std::string text = square().embedded(nodes + "]," + mesh(R"(,"indices":1)"));
    const TempFolder folder;
    const std::string path = folder.write("many.gltf", text);
    LoadOptions options;
    options.max_bytes = 1000 * (4 * sizeof(Vec3) + 2 * sizeof(Triangle));
    CHECK(load_scene(path, options).triangles.size() == 2000);
    --options.max_bytes;
    expect_error(ErrorCode::out_of_memory, {path, "LoadOptions::max_bytes"}, [&] { (void)load_scene(path, options); });
}

TEST_CASE("a glTF buffer behind a symbolic link that leaves the folder is not read") {
    const Gltf gltf = square();
    const TempFolder folder;
    const TempFolder other;
    const std::string outside = other.write("buffer.bin", gltf.bytes());
    std::filesystem::create_symlink(outside, folder.path("link.bin"));
    std::filesystem::create_symlink(other.path(""), folder.path("links"));
    for (const std::string uri : {"link.bin", "links/buffer.bin"}) {
        const std::string path = folder.write("a.gltf", gltf.json(mesh(R"(,"indices":1)"), R"(,"uri":")" + uri + '"'));
        expect_error(ErrorCode::io, {path, "below the folder"}, [&] { (void)load_scene(path); });
    }
}
