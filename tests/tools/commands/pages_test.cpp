// The pages of docs/results that bench/ makes from what the command writes.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/scratch_folder.hpp"
#include "tools/tool_process.hpp"

using namespace clbvh::test;
using Catch::Matchers::Contains;

namespace {

using Words = std::vector<std::string>;

struct Page {
    bool success = false;
    std::string text;  // standard output and error
};

Page make_page(const std::string& script, const Words& files) {
    std::string command = CLBVH_PYTHON " " CLBVH_BENCH "/" + script;
    for (const std::string& file : files)
        command += " " + file;
    Page page;
    std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
    REQUIRE(pipe != nullptr);
    for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe))
        page.text += static_cast<char>(c);
    page.success = pclose(pipe) == 0;
    INFO(page.text);
    CHECK_THAT(page.text, !Contains("Traceback"));
    return page;
}

void run(Words words, const std::string& json) {
    words.insert(words.end(), {"--runs", "1", "--json", json});
    const Outcome outcome = run_tool(words);
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
}

/// The same results, of trees without area, whose boxes no triangles enter but their own.
std::string without_costs(const ScratchFolder& folder, const std::string& json) {
    auto document = nlohmann::json::parse(std::ifstream(json));
    for (auto& result : document["results"])
        result["sah"] = result["epo"] = 0.0;
    const std::string path = folder.path("zero.json");
    std::ofstream(path) << document;
    return path;
}

/// Joining takes no table that was measured elsewhere, or that is not whole, and says which it is.
void refuse_strangers(const ScratchFolder& folder, const Words& files) {
    const std::string stranger = folder.path("stranger.json");
    const auto refused = [&](const char* pointer, const nlohmann::json& value, const std::string& part) {
        auto document = nlohmann::json::parse(std::ifstream(files[1]));
        document[nlohmann::json::json_pointer(pointer)] = value;
        std::ofstream(stranger) << document;
        const Page page = make_page("join_tables.py", {files[0], stranger});
        CHECK_FALSE(page.success);
        CHECK_THAT(page.text, Contains(stranger) && Contains(part));
    };
    refused("/machine/cpu", "Abacus 9", " was measured on Abacus 9 and ");
    refused("/device/name", "Loom 3", " and Loom 3, " + files[0] + " on ");
    refused("/device", nullptr, " and no device, ");
    refused("/incomplete", "interrupted", " is incomplete (interrupted)");
    refused("/anneal_passes", 21, " was measured with other options than " + files[0]);
}

}  // namespace

TEST_CASE("the page of the nine builders has their table beside the paper's") {
    const ScratchFolder folder;
    const std::string json = folder.path("table.json");
    run({"table", "gen:city:1000", "gen:soup:500", "--count", "1000", "--anneal-passes", "20"}, json);
    const Page page = make_page("aila_table.py", {json});
    CHECK(page.success);
    for (const char* part : {"annealing of 20 passes", "| STreelet |", "*paper, scalar*", "*0.446*", "gen:city:1000",
                             "**least**", "| EPO |", "| build ms |"})
        CHECK_THAT(page.text, Contains(part));
    CHECK_THAT(page.text, !Contains("## Turned"));
    const std::string turned = folder.path("turned.json");
    run({"table", "gen:city:1000", "gen:soup:500", "--count", "1000", "--anneal-passes", "20", "--rotate", "45"},
        turned);
    const Page both = make_page("aila_table.py", {json, turned});
    CHECK(both.success);
    CHECK_THAT(both.text, Contains("## Turned by 45 degrees") && Contains("| cost/ray | +"));
    CHECK_THAT(make_page("aila_table.py", {turned, folder.path("none.json")}).text, Contains("none.json"));
    const Page from_zero = make_page("aila_table.py", {without_costs(folder, json), turned});
    CHECK(from_zero.success);
    CHECK_THAT(from_zero.text, Contains("| EPO | - | - |") && Contains("| cost/ray | +"));
}

TEST_CASE("tables of scenes that were measured one at a time are joined") {
    const ScratchFolder folder;
    const Words files{folder.path("city.json"), folder.path("soup.json")};
    const Words rest{"--count", "1000", "--anneal-passes", "20"};
    Words city{"table", "gen:city:500"}, soup{"table", "gen:soup:500"};
    city.insert(city.end(), rest.begin(), rest.end());
    soup.insert(soup.end(), rest.begin(), rest.end());
    run(city, files[0]);
    run(soup, files[1]);
    const Page joined = make_page("join_tables.py", files);
    REQUIRE(joined.success);
    const auto document = nlohmann::json::parse(joined.text);
    CHECK(document["results"].size() == 18);
    const auto& scenes = document["correlation"]["scenes"];
    const auto& pooled = document["correlation"]["pooled"];
    REQUIRE(scenes.size() == 10);
    REQUIRE(pooled.size() == 5);
    const double a = scenes[0]["sah_epo"]["correlation"], b = scenes[5]["sah_epo"]["correlation"];
    CHECK(pooled[0]["measurement"] == scenes[0]["measurement"]);
    CHECK(pooled[0]["sah_epo"]["mean"].get<double>() == Approx((a + b) / 2));
    CHECK(pooled[0]["sah_epo"]["minimum"].get<double>() == Approx(std::min(a, b)));
    const std::string all = folder.path("all.json");
    std::ofstream(all) << joined.text;
    CHECK(make_page("aila_table.py", {all}).success);
    CHECK_THAT(make_page("join_tables.py", {all, files[1]}).text, Contains("gen:soup:500 is in more than one"));
    refuse_strangers(folder, files);
}

TEST_CASE("the page of optimisers has their costs beside the papers'") {
    const ScratchFolder folder;
    Words files{folder.path("table.json")};
    run({"table", "gen:city:500", "--count", "1000", "--anneal-passes", "20"}, files.front());
    for (const char* optimizer : {"", "rotate", "anneal"}) {
        files.push_back(folder.path("bench-" + std::string(optimizer) + ".json"));
        Words words{"bench", "gen:city:500", "--builders", "sweep-sah", "--no-validate"};
        if (*optimizer != '\0') words.insert(words.end(), {"--optimize", optimizer});
        run(words, files.back());
    }
    const Page page = make_page("optimizer_relations.py", files);
    CHECK(page.success);
    for (const char* part : {"Soda Hall", "(81.8 %)", "gen:city:500", "hill climbing", "Bittner"})
        CHECK_THAT(page.text, Contains(part));
    Words of_zero = files;
    of_zero.front() = without_costs(folder, files.front());
    const Page zero = make_page("optimizer_relations.py", of_zero);
    CHECK(zero.success);
    CHECK_THAT(zero.text, Contains("| gen:city:500 | - | - | - | - |"));
    files.pop_back();
    CHECK_THAT(make_page("optimizer_relations.py", files).text, Contains("no file of clbvh bench --optimize anneal"));
}

TEST_CASE("pages refuse what they are not made of") {
    const ScratchFolder folder;
    const std::string json = folder.path("bench.json");
    run({"bench", "gen:soup:100", "--builders", "median", "--no-validate"}, json);
    for (const char* script : {"aila_table.py", "ray_cost.py"}) {
        const Page page = make_page(script, {json});
        CHECK_FALSE(page.success);
        CHECK_THAT(page.text, Contains(std::string(script) + ": error: " + json));
    }
    CHECK_THAT(make_page("optimizer_relations.py", {json, json}).text, Contains(json + " holds no table"));
    CHECK_THAT(make_page("aila_table.py", {}).text, Contains("TABLE.json"));
}

TEST_CASE("the page of rays' costs is made from what metrics writes") {
    const ScratchFolder folder;
    const std::string json = folder.path("metrics.json");
    run({"metrics", "gen:city:500", "gen:soup:500", "--builders", "lbvh,median,binned-sah,sbvh", "--count", "1000"},
        json);
    const Page page = make_page("ray_cost.py", {json});
    CHECK(page.success);
    for (const char* part : {"**weights shared**", "| `sbvh` |", "gen:soup:500"})
        CHECK_THAT(page.text, Contains(part));
}

TEST_CASE("the page of presets has groups of scenes, and says what is missing") {
    const ScratchFolder folder;
    const std::string json = folder.path("presets.json");
    run({"bench", "gen:city:1000", "gen:soup:500", "--builders", "presets", "--rays"}, json);
    const Page page = make_page("presets.py", {json, "Towns=gen:city:1000", "Both=gen:city:1000,gen:soup:500"});
    CHECK(page.success);
    for (const char* part : {"## Towns", "## Both", "| `fast` | 1.000 | 1.000 | 1.000 | 1.000 | 1.000 |",
                             "| `highest` |", "gen:soup:500, 500 triangles:"})
        CHECK_THAT(page.text, Contains(part));
    const auto refused = [&](const std::vector<std::string>& words, const std::string& part) {
        const Page failed = make_page("presets.py", words);
        CHECK_FALSE(failed.success);
        CHECK_THAT(failed.text, Contains(part));
    };
    refused({json, "Towns"}, "'Towns' is no group");
    refused({json, "Towns=gen:city:7"}, "gen:city:7, which was not measured");
    const std::string plain = folder.path("plain.json");
    run({"bench", "gen:soup:100", "--builders", "median"}, plain);
    refused({plain}, "run clbvh bench with --rays");
}
