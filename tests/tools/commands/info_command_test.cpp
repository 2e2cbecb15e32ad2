#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/scratch_folder.hpp"
#include "tools/tool_process.hpp"

using namespace clbvh::test;
using Catch::Matchers::Contains;
using nlohmann::ordered_json;

namespace {

std::string write(const ScratchFolder& folder, const std::string& name, const std::string& text) {
    std::ofstream(folder.path(name)) << text;
    return folder.path(name);
}

/// A square of one face, once more as two triangles, an edge, a sliver, a NaN and a line.
const std::string kObj =
    "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv nan 0 0\nf 1 2 3 4\nf 1 2 3\nf 1 3 4\nf 1 2\nf 1 2 2\nf 1 2 5\nl 1 2\n";

}  // namespace

TEST_CASE("info counts what a file holds") {
    const ScratchFolder folder;
    const std::string path = write(folder, "mesh.obj", kObj);
    const Outcome outcome = run_tool({"info", path, "gen:sphere:1000", "--json", "-"});
    REQUIRE(outcome.exit_code == 0);
    const ordered_json scenes = ordered_json::parse(outcome.out)["scenes"];
    REQUIRE(scenes.size() == 2);
    const ordered_json expected{{"scene", path},      {"triangles", 6},        {"vertices", 5},
                                {"meshes", 1},        {"instances", 1},        {"faces", 6},
                                {"skipped_faces", 1}, {"points_and_lines", 1}, {"overlapping_fans", 0},
                                {"inactive", 1},      {"out_of_range", 0},     {"zero_area", 1},
                                {"duplicates", 2},    {"area", 8.0},           {"bounds", scenes[0]["bounds"]}};
    CHECK(scenes[0] == expected);
    CHECK(scenes[0]["bounds"]["lower"] == ordered_json{0.0, 0.0, 0.0});
    CHECK(scenes[0]["bounds"]["upper"] == ordered_json{2.0, 2.0, 0.0});
    CHECK(scenes[1]["triangles"] == 1000);
}

TEST_CASE("info says in words what is not as it should be, and nothing of the rest") {
    const ScratchFolder folder;
    const Outcome outcome = run_tool({"info", write(folder, "mesh.obj", kObj), "gen:sphere:1000"});
    CHECK(outcome.exit_code == 0);
    CHECK(outcome.err.empty());
    for (const char* part : {"of fewer than three corners", "with a NaN", "never hit by a ray", "duplicates"}) {
        const std::size_t first = outcome.out.find(part);
        CHECK(first != std::string::npos);
        CHECK(outcome.out.find(part, first + 1) == std::string::npos);
    }
    CHECK_THAT(outcome.out, Contains("gen:sphere:1000"));
}

TEST_CASE("info finds a scene that is not there before it looks at any") {
    const Outcome outcome = run_tool({"info", "gen:sphere:1000", missing_path("nosuch.obj")});
    CHECK(outcome.exit_code == 1);
    CHECK(outcome.out.empty());
    CHECK_THAT(outcome.err, Contains("nosuch.obj"));
    CHECK(run_tool({"info"}).exit_code == 2);
}

TEST_CASE("files of the longest names are written") {
    const ScratchFolder folder;
    const std::string tree(255, 't'), json(255, 'j');
    const Outcome outcome = run_tool(
        {"build", "gen:sphere:100", "--builder", "median", "-o", folder.path(tree), "--json", folder.path(json)});
    CHECK(outcome.err.empty());
    CHECK(outcome.exit_code == 0);
    CHECK(folder.file_count() == 2);
    CHECK(run_tool({"info", "gen:sphere:100", "--json", folder.path(std::string(256, 'x'))}).exit_code == 1);
}
