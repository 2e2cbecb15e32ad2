// bench --first-ray: what its rows hold, and what it refuses.
#include <catch2/catch.hpp>
#include <clbvh/core/error.hpp>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "embree/embree_peer.hpp"
#include "tools/tool_process.hpp"

using namespace clbvh;
using namespace clbvh::test;
using Catch::Matchers::Contains;
using nlohmann::ordered_json;

namespace {

bool has_peers() {
    try {
        tool::check_embree_peers({});
        return true;
    } catch (const Error&) {
        return false;
    }
}

std::set<std::string> keys_of(const ordered_json& object) {
    std::set<std::string> keys;
    for (const auto& [key, value] : object.items())
        keys.insert(key);
    return keys;
}

}  // namespace

TEST_CASE("bench --first-ray: a row for each builder, and for each of Embree's scenes") {
    std::vector<std::string> arguments{"bench",        "gen:city:2000",
                                       "gen:soup:500", "--first-ray",
                                       "--builders",   "binned-sah,median",
                                       "--runs",       "2",
                                       "--json",       "-"};
    std::vector<std::string> expected{"binned-sah", "median"};
    if (has_peers()) {
        arguments.emplace_back("--peers");
        for (const char* id : {"embree-low", "embree-medium", "embree-high"})
            expected.emplace_back(id);
    } else {
        WARN("SKIPPED: without Embree there are no peers to run");
    }
    const Outcome outcome = run_tool(arguments);
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    const ordered_json results = ordered_json::parse(outcome.out)["results"];
    REQUIRE(results.size() == 2 * expected.size());
    for (std::size_t i = 0; i < results.size(); ++i) {
        const ordered_json& row = results[i];
        INFO(row.dump(1));
        CHECK(keys_of(row) == std::set<std::string>{"scene", "triangles", "builder", "peer", "first_ray_ms", "cold_ms",
                                                    "stages", "primary_ns", "primary_single_ns", "closest_ns",
                                                    "closest_single_ns", "any_ns", "any_single_ns",
                                                    "bytes_per_triangle"});
        CHECK(row["builder"] == expected[i % expected.size()]);
        CHECK(row["triangles"] == (i < expected.size() ? 2000 : 500));
        const bool is_peer = row["builder"].get<std::string>().starts_with("embree");
        CHECK(row["peer"] == is_peer);
        CHECK(row["first_ray_ms"]["min"].get<double>() > 0.0);
        CHECK(row["first_ray_ms"]["median"].get<double>() >= row["first_ray_ms"]["min"].get<double>());
        for (const char* key : {"cold_ms", "primary_ns", "closest_ns", "any_ns"})
            CHECK(row[key].get<double>() > 0.0);
        for (const char* key : {"primary_single_ns", "closest_single_ns", "any_single_ns"})
            CHECK((is_peer ? row[key].is_null() : row[key].get<double>() > 0.0));
        CHECK(row["bytes_per_triangle"].is_null() == is_peer);
        if (!is_peer) CHECK(row["stages"].back()["name"] == "wide8");
    }
}

TEST_CASE("bench --first-ray: a table, with means where there are several scenes") {
    const Outcome outcome =
        run_tool({"bench", "gen:city:500", "gen:soup:500", "--first-ray", "--builders", "median", "--runs", "1"});
    REQUIRE(outcome.exit_code == 0);
    CHECK_THAT(outcome.out, Contains("gen:city:500: 500 triangles") && Contains("first ray ms") &&
                                Contains("geometric means over 2 scenes"));
    CHECK(std::regex_search(outcome.out, std::regex("[0-9] [(][0-9]+[.][0-9][)]")));  // in spans (one by one)
    const Outcome empty = run_tool({"bench", "gen:soup:0", "--first-ray", "--builders", "median", "--runs", "1"});
    INFO(empty.err);
    CHECK(empty.exit_code == 0);
}

TEST_CASE("bench --first-ray is a benchmark of its own") {
    for (const std::vector<std::string>& more :
         {std::vector<std::string>{"--stages"}, {"--rays"}, {"--no-validate"}, {"--sweep", "size"}}) {
        std::vector<std::string> arguments{"bench", "gen:soup:10", "--first-ray"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const Outcome outcome = run_tool(arguments);
        CHECK(outcome.exit_code != 0);
        CHECK_THAT(outcome.err, Contains("--first-ray"));
    }
}
