#include <algorithm>
#include <catch2/catch.hpp>
#include <clbvh/core/error.hpp>
#include <nlohmann/json.hpp>

#include "embree/embree_peer.hpp"
#include "tools/result_fields.hpp"
#include "tools/scratch_folder.hpp"
#include "tools/tool_process.hpp"

using namespace clbvh;
using namespace clbvh::test;
using Catch::Matchers::Contains;
using nlohmann::ordered_json;

namespace {

bool has_embree() {
    try {
        tool::check_embree_peers({});
        return true;
    } catch (const Error&) {
        return false;
    }
}

const std::vector<std::string> kNoDriver{no_drivers()};

/// A peer whose tree cannot be read: what it cost, and nothing of a tree.
void check_time_only(const ordered_json& result) {
    CHECK(field_names(result) == std::vector<std::string>{"scene", "triangles", "builder", "kind", "peer", "threads",
                                                          "build_ms", "mtris_per_s", "stages",
                                                          "peak_bytes_per_primitive", "inactive_primitives",
                                                          "native_sort_ms"});
    CHECK(result["build_ms"]["min"].get<double>() > 0.0);
    CHECK(result["peak_bytes_per_primitive"].get<double>() > 0.0);
    CHECK(result["stages"].size() == 1);
}

}  // namespace

TEST_CASE("bench puts its peers behind the builders, or says what to install") {
    const Outcome outcome = run_tool(
        {"bench", "gen:soup:1000", "--builders", "median", "--peers", "--runs", "2", "--threads", "1", "--json", "-"},
        kNoDriver);
    if (!has_embree()) {
        CHECK(outcome.exit_code == 1);
        CHECK_THAT(outcome.err, Contains("libembree-dev"));
        return;
    }
    REQUIRE(outcome.exit_code == 0);
    const ordered_json results = ordered_json::parse(outcome.out)["results"];
    std::vector<std::string> names;
    for (const ordered_json& result : results) {
        if (result["builder"] == "embree-commit-low") {
            check_time_only(result);
        } else {
            check_result(result, {"valid", "native_sort_ms"});
            CHECK(result["valid"] == true);
        }
        CHECK(result["threads"] == 1);
        CHECK(result["peer"] == (result["builder"] != "median"));
        names.push_back(result["builder"]);
    }
    CHECK(names ==
          std::vector<std::string>{"median", "embree-morton", "embree-binned", "embree-sbvh", "embree-commit-low"});
}

TEST_CASE("bench refuses what its peers cannot do") {
    const Outcome outcome =
        run_tool({"bench", "gen:soup:10", "--builders", "median", "--peers", "--max-leaf", "33"}, kNoDriver);
    CHECK(outcome.exit_code == 1);
    CHECK(outcome.out.empty());
    CHECK_THAT(outcome.err, Contains(has_embree() ? "--max-leaf" : "libembree-dev"));
}

TEST_CASE("bench says beneath its table that peers know no presplitting") {
    if (!has_embree()) {
        WARN("skipped: built without Embree");
        return;
    }
    std::vector<std::string> words{"bench", "gen:soup:100", "--builders", "median", "--peers", "--runs", "1"};
    const std::string note = "Embree's builders ran without presplitting and optimizers\n";
    CHECK_THAT(run_tool(words, kNoDriver).out, !Contains(note));
    words.emplace_back("--presplit");
    CHECK_THAT(run_tool(words, kNoDriver).out, Contains(note));
    words.back() = "--optimize=rotate";
    CHECK_THAT(run_tool(words, kNoDriver).out, Contains(note));
    words[3] = "highest";
    words.pop_back();
    CHECK_THAT(run_tool(words, kNoDriver).out, Contains(note));
}

TEST_CASE("bench shows no tree of a peer whose tree cannot be read") {
    if (!has_embree()) {
        WARN("skipped: built without Embree");
        return;
    }
    const Outcome outcome =
        run_tool({"bench", "gen:soup:1000", "--builders", "median", "--peers", "--runs", "1"}, kNoDriver);
    REQUIRE(outcome.exit_code == 0);
    const std::size_t begin = outcome.out.find("\nembree-commit-low ") + 1;
    REQUIRE(begin > 0);
    const std::string row = outcome.out.substr(begin, outcome.out.find('\n', begin) - begin);
    // SAH, ray cost, depth, leaves, primitives a leaf and validity; there is no baseline to compare with.
    CHECK(std::count(row.begin(), row.end(), '-') == 6 + 2);
}

TEST_CASE("peers run on the threads that there are, and standard error stays empty") {
    if (!has_embree()) {
        WARN("skipped: built without Embree");
        return;
    }
    const Outcome outcome = run_tool({"bench", "gen:soup:1000", "--builders", "median", "--peers", "--runs", "1",
                                      "--threads", "1024", "--json", "-"},
                                     kNoDriver);
    REQUIRE(outcome.exit_code == 0);
    CHECK(outcome.err.empty());
    const std::uint32_t all = tool::host_threads({});
    for (const ordered_json& result : ordered_json::parse(outcome.out)["results"])
        CHECK(result["threads"] == all);
}
