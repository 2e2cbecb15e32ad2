#include <catch2/catch.hpp>
#include <clbvh/catalog.hpp>
#include <clbvh/core/error.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "sweep/sweep.hpp"
#include "sweep/sweep_scene.hpp"
#include "tools/result_fields.hpp"
#include "tools/tool_process.hpp"

using namespace clbvh;
using namespace clbvh::test;
using namespace clbvh::tool;
using Catch::Matchers::Contains;
using nlohmann::ordered_json;

namespace {

using Words = std::vector<std::string>;
using Values = std::vector<std::uint32_t>;

ordered_json sweep(Words arguments) {
    arguments.insert(arguments.begin(), "bench");
    arguments.insert(arguments.end(), {"--runs", "1", "--json", "-"});
    const Outcome outcome = run_tool(arguments);
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    return ordered_json::parse(outcome.out)["results"];
}

void expect_failure(Words arguments, const std::string& part, int exit_code = 1) {
    arguments.insert(arguments.begin(), "bench");
    const Outcome outcome = run_tool(arguments);
    INFO(outcome.err);
    CHECK(outcome.exit_code == exit_code);
    CHECK(outcome.out.empty());
    CHECK_THAT(outcome.err, Contains("clbvh: error: ") && Contains(part));
}

}  // namespace

TEST_CASE("sizes grow by half powers of ten up to the largest") {
    CHECK(sweep_sizes(10000) == Values{10000});
    CHECK(sweep_sizes(12000) == Values{10000, 12000});
    CHECK(sweep_sizes(100000) == Values{10000, 31623, 100000});
    CHECK(sweep_sizes(1000000) == Values{10000, 31623, 100000, 316228, 1000000});
    CHECK(sweep_sizes(50000000).back() == 50000000);
    CHECK(sweep_sizes("gen:soup:40000:7", 0) == Values{10000, 31623, 40000});
    CHECK(sweep_sizes("gen:soup", 0) == Values{10000, 31623, 100000});
    CHECK(sweep_sizes("gen:soup:40000", 20000) == Values{10000, 20000});
    CHECK(with_count("gen:soup", 5) == "gen:soup:5");
    CHECK(with_count("gen:outlier:1e3:40000:7", 5) == "gen:outlier:1e3:5:7");
    CHECK(with_count("gen:mixed", 5) == "gen:mixed:6:5");
    CHECK(with_count("gen:soup:40000", 5) == "gen:soup:5");
    CHECK(with_count("gen:soup:40000:7", 5) == "gen:soup:5:7");
}

TEST_CASE("every option of a sweep is in its range, and changes the options") {
    for (const std::string& name : sweep_names()) {
        const Sweep& sweep = find_sweep(name);
        CHECK(sweep.what == name);
        CHECK(sweep.values.empty() == (name == "size"));
        for (const std::uint32_t value : sweep.values) {
            INFO(name << " " << value);
            BuildOptions options;
            set_swept(sweep, options, value);
            CHECK_NOTHROW(check_options(options));
            CHECK(options.ploc.search_radius == (name == "radius" ? value : BuildOptions{}.ploc.search_radius));
            CHECK(options.ploc.chunk_size == (name == "chunk" ? value : 0));
            CHECK(options.ploc.single_group_threshold == (name == "threshold" ? value : 0));
        }
    }
}

TEST_CASE("a sweep runs those builders of a group that read its option") {
    for (const auto& [name, kept] :
         {std::pair{"threshold", Words{"plocpp"}}, std::pair{"size", Words{"lbvh", "plocpp"}}}) {
        BuilderChoice choice;
        choice.ids = {"lbvh", "plocpp"};
        keep_readers(find_sweep(name), choice);
        CHECK(choice.ids == kept);
        CHECK_FALSE(choice.ids.empty());
    }
    BuilderChoice named;
    named.ids = named.named_ids = {"plocpp", "lbvh"};
    CHECK_THROWS_WITH(keep_readers(find_sweep("radius"), named),
                      Contains("lbvh does not read --radius") && Contains("ploc"));
    BuilderChoice host;
    host.ids = {"median"};
    CHECK_THROWS_WITH(keep_readers(find_sweep("chunk"), host), Contains("no builder that can run here reads --chunk"));
}

TEST_CASE("a sweep over an option builds with each of its values") {
    ProgressBar bar;
    BenchSettings settings;
    settings.builders = {"plocpp", "ploc"};
    settings.runs = 1;
    settings.options.device.shape = Shape::lane;
    settings.context = Context::open();
    const std::vector<std::pair<std::string, Values>> sweeps{{"radius", {1, 8}}, {"chunk", {64, 512}}};
    for (const auto& [what, values] : sweeps) {
        const auto results = sweep_scene(settings, find_sweep(what), values, "gen:city:3000", bar);
        REQUIRE(results.size() == 4);
        for (std::size_t i = 0; i < results.size(); ++i) {
            CHECK(results[i].builder == (i < 2 ? "plocpp" : "ploc"));
            CHECK(results[i].scene == "gen:city:3000");
            CHECK(results[i].triangles == 3000);
            CHECK(results[i].valid == true);
            CHECK(results[i].build_ms.min > 0.0);
            CHECK(results[i].copy_gb_per_s.has_value());
            CHECK(results[i].native_sort_ms.has_value());
            REQUIRE(results[i].sweep);
            CHECK(results[i].sweep->what == what);
            CHECK(results[i].sweep->value == values[i % 2]);
            if (what == "radius") CHECK(results[i].radius == values[i % 2]);
        }
        for (const std::size_t first : {0u, 2u}) {
            // Looking at the next neighbour alone makes worse trees; chunks leave the tree as it is.
            if (what == "radius") CHECK(results[first].sah > 1.02 * results[first + 1].sah);
            if (what == "chunk") CHECK(results[first].sah == results[first + 1].sah);
        }
    }
}

TEST_CASE("a threshold sweep leaves the tree as it is, and its JSON says what was swept") {
    const ordered_json results = sweep({"gen:city:3000", "--sweep", "threshold", "--builders", "device"});
    const Values& values = find_sweep("threshold").values;
    REQUIRE(results.size() == values.size());
    for (std::size_t i = 0; i < results.size(); ++i) {
        check_result(results[i], {"valid", "native_sort_ms", "copy_gb_per_s", "sweep"});
        CHECK(results[i]["builder"] == "plocpp");
        CHECK(results[i]["sweep"] == ordered_json{{"what", "threshold"}, {"value", values[i]}});
        CHECK(results[i]["valid"] == true);
        CHECK(results[i]["sah"] == results[0]["sah"]);
    }
}

TEST_CASE("a size sweep generates each size, for host builders too") {
    const ordered_json results = sweep({"gen:soup:20000:3", "--sweep", "size", "--builders", "lbvh,median"});
    REQUIRE(results.size() == 4);
    for (std::size_t i = 0; i < results.size(); ++i) {
        const std::uint32_t size = i % 2 == 0 ? 10000 : 20000;
        CHECK(results[i]["builder"] == (i < 2 ? "lbvh" : "median"));
        CHECK(results[i]["triangles"] == size);
        CHECK(results[i]["scene"] == "gen:soup:" + std::to_string(size) + ":3");
        CHECK(results[i]["sweep"] == ordered_json{{"what", "size"}, {"value", size}});
        CHECK(results[i]["references"] == size);
    }
}

TEST_CASE("a sweep prints one table a scene") {
    const Outcome outcome = run_tool({"bench", "gen:soup:500", "gen:line:500", "--sweep", "threshold", "--builders",
                                      "plocpp", "--runs", "1", "--no-validate"});
    REQUIRE(outcome.exit_code == 0);
    CHECK_THAT(outcome.out, Contains("gen:soup:500 (500 triangles): threshold") && Contains("gen:line:500") &&
                                Contains("ns/triangle") && Contains("SAH/best") && !Contains("geometric means"));
}

TEST_CASE("a sweep that cannot be is refused before any work") {
    expect_failure({"gen:soup:100", "--sweep", "colour"}, "colour", 2);
    expect_failure({"gen:soup:100", "--sweep", "size", "--sweep-to", "0"}, "--sweep-to", 2);
    expect_failure({"gen:soup:100", "--sweep", "radius", "--builders", "ploc,lbvh"}, "lbvh does not read --radius");
    expect_failure({"gen:soup:100", "--sweep", "threshold", "--builders", "host"}, "those that do: plocpp");
    expect_failure({"gen:soup:20000", CLBVH_TOOL, "--sweep", "size"}, CLBVH_TOOL " has one size");
    expect_failure({"gen:soup:20000", "gen:line:9999", "--sweep", "size"}, "gen:line:9999: sizes begin at 10000");
    expect_failure({"gen:soup:100", "--sweep-to", "20000"}, "--sweep-to is for --sweep size");
    expect_failure({"gen:soup:100", "--sweep", "radius", "--peers"}, "--peers");
    expect_failure({"gen:soup:100", "--sweep", "radius", "--stages"}, "--stages");
}

TEST_CASE("chunks are of the lane shape") {
    const Outcome outcome =
        run_tool({"bench", "gen:soup:500", "--sweep", "chunk", "--shape", "group", "--builders", "plocpp"});
    CHECK(outcome.exit_code == 1);
    CHECK_THAT(outcome.err, Contains("plocpp runs in the group shape here") && Contains("--shape lane"));
}
