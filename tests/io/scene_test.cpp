#include "clbvh/io/scene.hpp"

#include <catch2/catch.hpp>
#include <string>

#include "io/temp_folder.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

void expect_scene_error(ErrorCode code, const std::string& scene, std::initializer_list<std::string> parts) {
    INFO(scene);
    expect_error(code, parts, [&] { (void)load_scene(scene); });
}

}  // namespace

TEST_CASE("a generated scene is named with its count and seed") {
    CHECK(load_scene("gen:soup").triangles.size() == kDefaultSceneTriangles);
    CHECK(load_scene("gen:hair:123").vertices == generate_scene("hair", 123).vertices);
    CHECK(load_scene("gen:hair:123:7").vertices == generate_scene("hair", 123, 7).vertices);
    CHECK(load_scene("gen:line:0").triangles.empty());
    CHECK(load_scene("gen:outlier:1e3:123:7").vertices == generate_scene("outlier:1e3", 123, 7).vertices);
    CHECK(load_scene("gen:mixed").triangles.size() == kDefaultSceneTriangles);
}

TEST_CASE("malformed names of generated scenes are refused") {
    const ErrorCode code = ErrorCode::invalid_input;
    expect_scene_error(code, "gen:foo", {"\"foo\"", "soup, clustered, terrain, city, hair, particles, line, sphere"});
    expect_scene_error(code, "gen:", {"unknown scene generator \"\""});
    expect_scene_error(code, "gen:soup:abc", {"gen:soup:abc", "count \"abc\" is not a whole number"});
    expect_scene_error(code, "gen:soup:-3", {"count \"-3\" is not a whole number"});
    expect_scene_error(code, "gen:soup:", {"count \"\" is not a whole number"});
    expect_scene_error(code, "gen:soup:1e3", {"count \"1e3\" is not a whole number"});
    expect_scene_error(code, "gen:soup:10:x", {"seed \"x\" is not a whole number"});
    expect_scene_error(code, "gen:soup:1:2:3", {"expected gen:NAME[:COUNT[:SEED]]"});
    expect_scene_error(code, "gen:outlier:1e3:10:1:2", {"expected gen:NAME[:PARAMETER[:COUNT[:SEED]]]"});
    expect_scene_error(code, "gen:outlier:5:10", {"gen:outlier:5:10", "D", "\"5\"", "10 to 1e+12"});
    expect_scene_error(code, "gen:soup:1073741824", {"1073741824", "over the limit of 1073741823"});
    expect_scene_error(code, "gen:soup:18446744073709551616", {"count", "too large"});
}

TEST_CASE("a missing file is reported whatever its format") {
    const TempFolder folder;
    for (const std::string name : {"none.obj", "none.ply", "none.stl", "none.unheard-of", "none"}) {
        const std::string path = folder.path(name).string();
        expect_scene_error(ErrorCode::io, path, {path, "No such file or directory"});
    }
    expect_scene_error(ErrorCode::io, "", {"No such file or directory"});
}

TEST_CASE("what is not a regular file is not read") {
    const TempFolder folder;
    const std::filesystem::path path = folder.path("folder.obj");
    std::filesystem::create_directory(path);
    expect_scene_error(ErrorCode::io, path.string(), {path.string(), "Is a directory"});
    std::filesystem::create_symlink("/dev/zero", folder.path("endless.obj"));
    expect_scene_error(ErrorCode::io, folder.path("endless.obj").string(), {"not a regular file"});
}

TEST_CASE("loading can be cancelled, and says how far it is") {
    const TempFolder folder;
    std::string text = "OFF\n100000 0 0\n";
    for (int i = 0; i < 100000; ++i)
        text += "0.25 0.5 0.75\n";
    const std::string path = folder.write("many.off", text);
    std::vector<double> fractions;
    (void)load_scene(path, {[&](const Progress& progress) {
                                CHECK(progress.stage == "load");
                                fractions.push_back(progress.fraction);
                                return true;
                            },
                            nullptr});
    REQUIRE(fractions.size() > 3);
    CHECK(std::ranges::is_sorted(fractions));
    CHECK(fractions.back() <= 1.0);
    CHECK(fractions.back() > 0.8);
    expect_error(ErrorCode::cancelled, {path}, [&] {
        (void)load_scene(path, {[](const Progress&) { return false; }, nullptr});
    });
}
