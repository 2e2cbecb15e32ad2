#include <catch2/catch.hpp>
#include <clbvh/builder.hpp>
#include <clbvh/eval/rotation.hpp>
#include <clbvh/io/scene.hpp>
#include <clbvh/metrics/sah.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/scratch_folder.hpp"
#include "tools/tool_process.hpp"

using namespace clbvh;
using namespace clbvh::test;
using Catch::Matchers::Contains;
using nlohmann::ordered_json;

namespace {

using Words = std::vector<std::string>;

Outcome run_with(Words words, const Words& more) {
    words.insert(words.end(), more.begin(), more.end());
    return run_tool(words);
}

ordered_json json_of(const Words& words, const Words& more) {
    Words all = words;
    all.insert(all.end(), more.begin(), more.end());
    const Outcome outcome = run_with(all, {"--json", "-"});
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    return ordered_json::parse(outcome.out);
}

double turned_sah(double degrees) {
    Builder builder("median");
    builder.upload(rotated(generate_scene("city", 2000), Rotation({1, 1, 1}, degrees)));
    builder.run();
    return sah_cost(builder.download());
}

const Words kBuild{"build", "gen:city:2000", "--builder", "median"};
const Words kBench{"bench", "gen:city:2000", "--builders", "median", "--runs", "1"};
const Words kSweep{"bench", "gen:city:2000", "--builders", "median", "--runs", "1", "--sweep", "size"};

}  // namespace

TEST_CASE("every command that takes scenes turns them by --rotate") {
    const double upright = turned_sah(0.0);
    CHECK(turned_sah(45.0) > upright);
    for (const Words& command : {kBuild, kBench}) {
        const ordered_json plain = json_of(command, {});
        CHECK(plain["rotate_degrees"] == 0.0);
        CHECK(plain["results"][0]["sah"] == upright);
        const ordered_json turned = json_of(command, {"--rotate", "45"});
        CHECK(turned["rotate_degrees"] == 45.0);
        CHECK(turned["results"][0]["sah"] == turned_sah(45.0));
    }
    Words sizes = kSweep;
    sizes[1] = "gen:city:10000";
    CHECK(json_of(sizes, {"--rotate", "-45.5"})["results"][0]["sah"] > json_of(sizes, {})["results"][0]["sah"]);
    const ScratchFolder folder;
    const Words tune{"tune", "gen:soup:300", "--runs", "1", "-o", folder.path("profile.txt")};
    CHECK(json_of(tune, {"--rotate", "45"})["rotate_degrees"] == 45.0);
}

TEST_CASE("tables say that scenes were turned, and only then") {
    for (const Words& command : {kBuild, kBench}) {
        CHECK_THAT(run_with(command, {"--rotate", "45"}).out, Contains("scenes turned by 45 degrees about (1, 1, 1)"));
        CHECK_THAT(run_with(command, {}).out, !Contains("turned"));
    }
}

TEST_CASE("turning with --rotate wants a finite number") {
    for (const char* value : {"", "nan", "inf", "-inf", "far", "1e999"}) {
        INFO(value);
        const Outcome outcome = run_with(kBuild, {"--rotate", value});
        CHECK(outcome.exit_code == 2);
        CHECK_THAT(outcome.err, Contains("--rotate"));
    }
}
