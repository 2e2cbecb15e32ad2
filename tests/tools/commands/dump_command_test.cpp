#include <algorithm>
#include <catch2/catch.hpp>
#include <clbvh/builder.hpp>
#include <clbvh/io/bvh_file.hpp>
#include <clbvh/io/layout_file.hpp>
#include <clbvh/io/scene.hpp>
#include <clbvh/metrics/tree_statistics.hpp>
#include <cstdio>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tools/result_fields.hpp"
#include "tools/scratch_folder.hpp"
#include "tools/tool_process.hpp"

using namespace clbvh;
using namespace clbvh::test;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using nlohmann::ordered_json;

namespace {

using Words = std::vector<std::string>;

/// A root with a leaf of two primitives and an inner node over two leaves of one, and a gap before them.
Bvh small_tree() {
    Bvh bvh;
    bvh.nodes = {{{0, 0, 0}, 4, {4, 1, 1}, 0},
                 {},
                 {},
                 {},
                 {{0.1f, 0, 0}, 1, {2, 1, 1}, 2},
                 {{2, 0, 0}, 6, {4, 1, 1}, 0},
                 {{2, 0, 0}, 0, {3, 1, 0.5f}, 1},
                 {{3, -1e-7f, 0}, 3, {4, 1, 1e9f}, 1}};
    bvh.primitive_ids = {7, 0, 5, 2};
    bvh.primitive_count = 9;
    return bvh;
}

/// Runs `dump` on a tree; it succeeds.
std::string dump_of(const Bvh& bvh, const Words& options) {
    const ScratchFolder folder;
    write_bvh(bvh, folder.path("tree.clbvh"));
    Words words{"dump", folder.path("tree.clbvh")};
    words.insert(words.end(), options.begin(), options.end());
    const Outcome outcome = run_tool(words);
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    CHECK(outcome.err.empty());
    return outcome.out;
}

std::size_t count_lines(const std::string& text, const std::string& start) {
    std::istringstream lines(text);
    std::size_t count = 0;
    for (std::string line; std::getline(lines, line);)
        count += line.starts_with(start) ? 1 : 0;
    return count;
}

}  // namespace

TEST_CASE("dump shows a tree as JSON, a node a line") {
    const std::string text = dump_of(small_tree(), {"--json"});
    CHECK_THAT(text, Contains("\n    {\"node\": 4, \"depth\": 1, \"lower\": [0.1, 0, 0], \"upper\": [2, 1, 1], "
                              "\"primitives\": [0, 5]},\n"));
    const ordered_json document = ordered_json::parse(text);
    CHECK(field_names(document) == Words{"primitive_count", "split_references", "slots", "nodes"});
    CHECK(document["primitive_count"] == 9);
    CHECK(document["split_references"] == false);
    CHECK(document["slots"] == 8);
    const ordered_json& nodes = document["nodes"];
    std::vector<int> order;
    for (const ordered_json& node : nodes)
        order.push_back(node["node"]);
    CHECK(order == std::vector{0, 4, 5, 6, 7});
    CHECK(nodes[0]["children"] == ordered_json{4, 5});
    CHECK(nodes[2]["children"] == ordered_json{6, 7});
    CHECK(nodes[4]["depth"] == 2);
    CHECK(nodes[4]["primitives"] == ordered_json{2});
    CHECK(nodes[4]["lower"][1].get<float>() == -1e-7f);
    CHECK(nodes[4]["upper"][2].get<float>() == 1e9f);
    CHECK_FALSE(nodes[4].contains("children"));
    CHECK_FALSE(nodes[0].contains("primitives"));
}

TEST_CASE("dump's JSON of a built tree has what the tree has") {
    const Mesh mesh = generate_scene("city", 500);
    const Bvh bvh = Builder("sbvh").build(mesh);
    const TreeStatistics statistics = tree_statistics(bvh);
    const ordered_json document = ordered_json::parse(dump_of(bvh, {"--json", "-"}));
    CHECK(document["split_references"] == bvh.split_references);
    REQUIRE(document["nodes"].size() == statistics.nodes);
    std::uint32_t deepest = 0;
    std::size_t references = 0;
    for (const ordered_json& node : document["nodes"]) {
        const Node& expected = bvh.nodes[node["node"].get<std::size_t>()];
        deepest = std::max(deepest, node["depth"].get<std::uint32_t>());
        for (std::size_t axis = 0; axis < 3; ++axis) {
            REQUIRE(node["lower"][axis].get<float>() == expected.lower[axis]);
            REQUIRE(node["upper"][axis].get<float>() == expected.upper[axis]);
        }
        if (expected.is_leaf()) references += node["primitives"].size();
    }
    CHECK(deepest == statistics.depth());
    CHECK(references == statistics.references);
}

TEST_CASE("dump draws boxes as OBJ, in a group a depth") {
    const std::string text = dump_of(small_tree(), {"--obj"});
    CHECK_THAT(text, StartsWith("# boxes of 5 nodes\ng depth_0\nv 0 0 0\nv 4 0 0\nv 0 1 0\nv 4 1 0\nv 0 0 1\n"));
    CHECK(count_lines(text, "g ") == 3);
    CHECK(count_lines(text, "v ") == 5 * 8);
    CHECK(count_lines(text, "l ") == 5 * 12);
    const std::string above = text.substr(0, text.find("g depth_2"));
    CHECK(count_lines(above, "v ") == 3 * 8);
    // Each edge of a box joins two corners that differ along one axis, and each corner has three.
    std::map<int, int> edges;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        int a = 0, b = 0;
        if (std::sscanf(line.c_str(), "l %d %d", &a, &b) != 2) continue;
        CHECK((a - 1) / 8 == (b - 1) / 8);
        const int difference = ((a - 1) % 8) ^ ((b - 1) % 8);
        CHECK((difference == 1 || difference == 2 || difference == 4));
        ++edges[a];
        ++edges[b];
    }
    CHECK(edges.size() == 5 * 8);
    CHECK(std::ranges::all_of(edges, [](const auto& edge) { return edge.second == 3; }));
}

TEST_CASE("dump leaves out what lies deeper than asked for") {
    const ordered_json document = ordered_json::parse(dump_of(small_tree(), {"--json", "--depth", "1"}));
    CHECK(document["nodes"].size() == 3);
    CHECK(document["nodes"][2]["children"] == ordered_json{6, 7});
    CHECK(count_lines(dump_of(small_tree(), {"--obj", "--depth", "0"}), "v ") == 8);
    CHECK(count_lines(dump_of(small_tree(), {"--obj", "--depth", "9"}), "v ") == 5 * 8);
}

TEST_CASE("dump writes files, and shows the empty tree") {
    const ScratchFolder folder;
    CHECK(dump_of(small_tree(), {"--json", folder.path("tree.json")}).empty());
    CHECK(ordered_json::parse(read_text(folder.path("tree.json")))["nodes"].size() == 5);
    CHECK(dump_of(small_tree(), {"--obj", folder.path("tree.obj")}).empty());
    CHECK(read_text(folder.path("tree.obj")) == dump_of(small_tree(), {"--obj", "-"}));
    CHECK(ordered_json::parse(dump_of({}, {"--json"}))["nodes"].empty());
    CHECK(dump_of({}, {"--obj"}) == "# boxes of 0 nodes\n");
}

TEST_CASE("boxes that are not finite are null in dump's JSON, and an error in OBJ") {
    const ScratchFolder folder;
    Bvh bvh = small_tree();
    bvh.nodes[6].upper[2] = std::numeric_limits<float>::infinity();
    bvh.nodes[7].lower[0] = std::numeric_limits<float>::quiet_NaN();
    const ordered_json document = ordered_json::parse(dump_of(bvh, {"--json"}));
    CHECK(document["nodes"][3]["upper"][2].is_null());
    CHECK(document["nodes"][4]["lower"][0].is_null());
    write_bvh(bvh, folder.path("tree.clbvh"));
    const Outcome outcome = run_tool({"dump", folder.path("tree.clbvh"), "--obj"});
    CHECK(outcome.exit_code == 1);
    CHECK(outcome.out.empty());
    CHECK_THAT(outcome.err, StartsWith("clbvh: error: node 6: its box is not finite"));
}

TEST_CASE("dump shows whole layouts as JSON, and no more") {
    const ScratchFolder folder;
    const std::string path = folder.path("layout");
    write_layout(make_layout<PairLayout>(small_tree()), path);
    CHECK(run_tool({"dump", path, "--json"}).exit_code == 0);
    for (const Words& options : {Words{"--obj"}, Words{"--json", "-", "--depth", "3"}}) {
        Words words{"dump", path};
        words.insert(words.end(), options.begin(), options.end());
        const Outcome outcome = run_tool(words);
        CHECK(outcome.exit_code == 1);
        CHECK_THAT(outcome.err, Contains("holds a layout"));
    }
    std::string damaged = read_text(path);
    damaged.back() ^= 1;
    std::ofstream(path, std::ios::binary) << damaged;
    CHECK_THAT(run_tool({"dump", path, "--json"}).err, Contains("the hash does not match"));
}

TEST_CASE("dump says what it cannot read or write, and what is missing") {
    const ScratchFolder folder;
    write_bvh(small_tree(), folder.path("tree.clbvh"));
    const auto fails = [](const Words& words, int code, const std::string& part) {
        const Outcome outcome = run_tool(words);
        INFO(outcome.err);
        CHECK(outcome.exit_code == code);
        CHECK(outcome.out.empty());
        CHECK_THAT(outcome.err, StartsWith("clbvh: error: ") && Contains(part));
    };
    const std::string tree = folder.path("tree.clbvh");
    fails({"dump", folder.path("none.clbvh"), "--json"}, 1, "none.clbvh");
    fails({"dump", "/proc/self/status", "--json"}, 1, "/proc/self/status");
    fails({"dump", tree, "--json", folder.path("none/tree.json")}, 1, "cannot write");
    fails({"dump", tree}, 2, "--json");
    fails({"dump", tree, "--json", "--obj"}, 2, "--obj");
    fails({"dump", "--json"}, 2, "tree");
    fails({"dump", tree, "--json", "-", "--depth", "-1"}, 2, "--depth");
}
