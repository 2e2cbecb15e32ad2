#include <catch2/catch.hpp>
#include <clbvh/registry.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "result_fields.hpp"
#include "scratch_folder.hpp"
#include "tool_process.hpp"

using namespace clbvh;
using namespace clbvh::test;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using nlohmann::ordered_json;

namespace {

using Words = std::vector<std::string>;

Words lines_of(const std::string& text) {
    Words lines(1);
    for (const char c : text) {
        if (c == '\n') {
            lines.emplace_back();
        } else {
            lines.back() += c;
        }
    }
    return lines;
}

std::size_t count_lines_that_start_with(const std::string& text, const std::string& start) {
    std::size_t count = 0;
    for (const std::string& line : lines_of(text))
        count += line.starts_with(start) ? 1 : 0;
    return count;
}

}  // namespace

TEST_CASE("bench describes every builder on every scene") {
    const Outcome outcome = run_tool({"bench", "gen:soup:3000", "gen:sphere:2000", "--runs", "2", "--json", "-"});
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    CHECK(outcome.err.empty());
    const ordered_json document = ordered_json::parse(outcome.out);
    CHECK(field_names(document) == Words{"device", "results"});
    check_device(document["device"]);
    const ordered_json& results = document["results"];
    REQUIRE(results.size() == 2 * builders().size());
    for (std::size_t i = 0; i < results.size(); ++i) {
        check_result(results[i], {"valid", "native_sort_ms"});
        const bool first_scene = i < builders().size();
        CHECK(results[i]["scene"] == (first_scene ? "gen:soup:3000" : "gen:sphere:2000"));
        CHECK(results[i]["triangles"] == (first_scene ? 3000 : 2000));
        CHECK(results[i]["builder"] == builders()[i % builders().size()].id);
        CHECK(results[i]["valid"] == true);
        CHECK(results[i]["native_sort_ms"]["median"].get<double>() > 0.0);
        CHECK(field_names(results[i]["native_sort_ms"]) == Words{"median", "min", "max"});
    }
}

TEST_CASE("bench runs the builders that are named, each once, in that order") {
    const Outcome outcome = run_tool({"bench", "gen:soup:1000", "--builders", "lbvh,plocpp,lbvh", "--runs", "1",
                                      "--radius", "4", "--shape", "group", "--no-validate", "--json", "-"});
    REQUIRE(outcome.exit_code == 0);
    const ordered_json results = ordered_json::parse(outcome.out)["results"];
    REQUIRE(results.size() == 2);
    CHECK(results[0]["builder"] == "lbvh");
    CHECK(results[1]["builder"] == "plocpp");
    CHECK(results[1]["radius"] == 4);
    for (const ordered_json& result : results) {
        check_result(result, {"native_sort_ms"});
        CHECK(result["shape"] == "group");
    }
}

TEST_CASE("bench prints one table a scene, and the means of several") {
    const Outcome one = run_tool({"bench", "gen:soup:1000", "--runs", "1"});
    REQUIRE(one.exit_code == 0);
    CHECK_THAT(one.out, Contains("gen:soup:1000: 1000 triangles") && !Contains("geometric means"));
    const Outcome two = run_tool({"bench", "gen:soup:1000", "gen:line:1000", "--runs", "1"});
    REQUIRE(two.exit_code == 0);
    CHECK_THAT(two.out, Contains("geometric means over 2 scenes"));
    for (const char* column : {"median ms", "min ms", "Mtris/s", "vs ploc", "x sort", "SAH", "depth", "launches",
                               "iterations", "bytes/prim", "valid"}) {
        CHECK_THAT(one.out, Contains(column));
    }
    for (const BuilderInfo& builder : builders()) {
        const std::string start = std::string(builder.id) + " ";
        CHECK(count_lines_that_start_with(one.out, start) == 1);
        CHECK(count_lines_that_start_with(two.out, start) == 3);
    }
    CHECK(count_lines_that_start_with(two.out, "native sort (64-bit keys, 32-bit values, ") == 2);
}

TEST_CASE("the columns of bench's table are aligned") {
    const Outcome outcome = run_tool({"bench", "gen:soup:1000", "--runs", "1"});
    REQUIRE(outcome.exit_code == 0);
    const Words lines = lines_of(outcome.out);
    for (std::size_t i = 2; i < 2 + builders().size(); ++i)
        CHECK(lines.at(i).size() == lines.at(1).size());
}

TEST_CASE("without ploc there is nothing to be faster than") {
    const Outcome outcome = run_tool({"bench", "gen:soup:1000", "--builders", "lbvh", "--runs", "1"});
    REQUIRE(outcome.exit_code == 0);
    const std::string row = lines_of(outcome.out).at(2);
    CHECK_THAT(row, StartsWith("lbvh ") && Contains("  -  ") && !Contains("x  "));
}

TEST_CASE("bench names what is wrong with its input, and prints no table") {
    const ScratchFolder folder;
    const auto expect_failure = [](Words arguments, const std::string& part) {
        arguments.insert(arguments.begin(), {"bench", "--runs", "1"});
        const Outcome outcome = run_tool(arguments);
        INFO(outcome.err);
        CHECK(outcome.exit_code == 1);
        CHECK(outcome.out.empty());
        CHECK_THAT(outcome.err, Contains("clbvh: error: ") && Contains(part));
    };
    expect_failure({"gen:soup:10", "--builders", "ploc,quick"}, "quick");
    expect_failure({"gen:soup:10", "--builders", "ploc,"}, "plocpp-two-level");
    expect_failure({"gen:soup:10", "--radius", "33"}, "radius is 33");
    expect_failure({"gen:soup:10", "--device", "no such device"}, "no such device");
    expect_failure({"/nonexistent/scene.obj"}, "/nonexistent/scene.obj");
    expect_failure({"gen:soup:10", "--json", folder.path("none/x.json")}, "none/x.json");
}
