#include <catch2/catch.hpp>
#include <clbvh/io/ray_file.hpp>
#include <nlohmann/json.hpp>
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

Words trace_words(const Words& arguments) {
    Words words{"trace", "--runs", "1", "--count", "5000"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    return words;
}

ordered_json document_of(Words arguments, const Words& environment = {}) {
    arguments.insert(arguments.end(), {"--json", "-"});
    const Outcome outcome = run_tool(trace_words(arguments), environment);
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    CHECK(outcome.err.empty());
    ordered_json document = ordered_json::parse(outcome.out);
    CHECK(field_names(document) == Words{"machine", "device", "profile", "rotate_degrees", "options", "results"});
    return document;
}

ordered_json results_of(const Words& arguments) {
    return document_of(arguments)["results"];
}

void expect_failure(const Words& arguments, const Words& parts, int code = 1) {
    const Outcome outcome = run_tool(trace_words(arguments));
    INFO(outcome.err);
    CHECK(outcome.exit_code == code);
    CHECK_THAT(outcome.err, StartsWith("clbvh: error: "));
    for (const std::string& part : parts)
        CHECK_THAT(outcome.err, Contains(part));
}

}  // namespace

TEST_CASE("trace writes what rays cost with each builder, and with binned-sah") {
    const ordered_json results = results_of({"gen:city:3000", "--builders", "median,sbvh", "--rays", "primary,ao"});
    REQUIRE(results.size() == 6);
    const Words builders{"median", "sbvh", "binned-sah", "median", "sbvh", "binned-sah"};
    for (std::size_t i = 0; i < 6; ++i) {
        const ordered_json& result = results[i];
        CHECK(
            field_names(result) ==
            Words{"scene",         "triangles",      "builder",          "kind",        "sah",        "device",
                  "rays",          "ray_count",      "ray_hash",         "threads",     "seed",       "camera",
                  "hits",          "mismatches",     "trace_ms",         "mrays_per_s", "ns_per_ray", "relative_speed",
                  "inner_per_ray", "leaves_per_ray", "triangles_per_ray"});
        CHECK(result["scene"] == "gen:city:3000");
        CHECK(result["triangles"] == 3000);
        CHECK(result["builder"] == builders[i]);
        CHECK(result["device"] == "host");
        CHECK(result["rays"] == (i < 3 ? "primary" : "ao"));
        CHECK(result["mismatches"] == 0);
        const ordered_json& first = results[i < 3 ? 0 : 3];
        for (const char* same : {"ray_count", "ray_hash", "hits", "camera"})
            CHECK(result[same] == first[same]);
        const double count = result["ray_count"];
        const double milliseconds = result["trace_ms"]["median"];
        CHECK(count == Approx(5000.0).epsilon(0.1));
        CHECK(result["hits"] > 0);
        CHECK(result["ns_per_ray"] == Approx(milliseconds * 1e6 / count));
        CHECK(result["mrays_per_s"] == Approx(count / milliseconds / 1e3));
        CHECK(result["inner_per_ray"] > 1.0);
        CHECK(result["triangles_per_ray"] >= result["leaves_per_ray"]);
    }
    CHECK(results[2]["relative_speed"] == 1.0);
    CHECK(results[0]["inner_per_ray"] != results[1]["inner_per_ray"]);
}

TEST_CASE("trace counts what the host counts, on a device as well") {
    const Words words{"gen:city:2000", "--builders", "median,binned-sah", "--rays", "diffuse,shadow"};
    Words on_device = words;
    on_device.insert(on_device.end(), {"--tracer", "device"});
    const ordered_json host = results_of(words);
    const ordered_json document = document_of(on_device);
    check_device(document["device"]);
    const ordered_json& device = document["results"];
    REQUIRE(device.size() == host.size());
    for (std::size_t i = 0; i < host.size(); ++i) {
        CHECK(device[i]["device"] == document["device"]["name"]);
        CHECK(!device[i].contains("threads"));
        for (const char* same : {"ray_hash", "hits", "mismatches", "inner_per_ray", "leaves_per_ray", "camera"})
            CHECK(device[i][same] == host[i][same]);
    }
}

TEST_CASE("the same seed makes the same rays, whatever the tree and the threads") {
    const auto hash = [](const Words& options) {
        Words words{"gen:terrain:2000"};
        words.insert(words.end(), options.begin(), options.end());
        return results_of(words)[0]["ray_hash"].get<std::string>();
    };
    const std::string plain = hash({"--builder", "median"});
    CHECK(plain.size() == 16);
    CHECK(hash({"--builder", "median"}) == plain);
    CHECK(hash({"--builder", "locally-ordered"}) == plain);
    CHECK(hash({"--builder", "median", "--threads", "1"}) == plain);
    CHECK(hash({"--builder", "median", "--seed", "2"}) != plain);
    CHECK(hash({"--builder", "median", "--camera", "0,5,0,0.5,0,0.5"}) != plain);
    CHECK(hash({"--builder", "median", "--up", "x"}) != plain);
}

TEST_CASE("trace on more threads than there are runs on those there are, and says nothing else") {
    const Outcome outcome = run_tool({"trace", "gen:soup:500", "--builders", "median", "--rays", "random", "--count",
                                      "100", "--threads", "1024", "--runs", "1"});
    CHECK(outcome.exit_code == 0);
    CHECK(outcome.err.empty());
}

TEST_CASE("rays that were saved are traced again") {
    const ScratchFolder folder;
    const std::string file = folder.path("rays");
    const Words words{"gen:city:2000", "--builder", "median", "--rays", "shadow"};
    const auto with = [&](const char* option) {
        Words all = words;
        all.insert(all.end(), {option, file});
        return results_of(all)[0];
    };
    const ordered_json made = with("--save-rays");
    CHECK(read_rays(file).size() == made["ray_count"]);
    const ordered_json loaded = with("--load-rays");
    CHECK(loaded["loaded_from"] == file);
    CHECK(!loaded.contains("seed"));
    for (const char* same : {"ray_count", "ray_hash", "hits", "inner_per_ray"})
        CHECK(loaded[same] == made[same]);
}

TEST_CASE("the camera turns with the scene, and is told as --camera takes it") {
    const auto result = [](const std::vector<std::string>& options) {
        std::vector<std::string> words{"gen:city:2000", "--builder", "median", "--rays", "primary"};
        words.insert(words.end(), options.begin(), options.end());
        return results_of(words)[0];
    };
    const ordered_json plain = result({"--rotate", "0"});
    const ordered_json turned = result({"--rotate", "120"});
    CHECK(turned["camera"] == plain["camera"]);
    CHECK(turned["ray_hash"] != plain["ray_hash"]);
    // Rays that pass an edge closely may change sides by rounding.
    CHECK(turned["hits"].get<double>() == Approx(plain["hits"].get<double>()).margin(5));
    CHECK(turned["ray_count"] == plain["ray_count"]);
    const ordered_json again = result({"--rotate", "120", "--camera", turned["camera"].get<std::string>()});
    CHECK(again["ray_hash"] == turned["ray_hash"]);
}

TEST_CASE("trace prints a table for people") {
    const Outcome outcome = run_tool(trace_words({"gen:soup:2000", "--builder", "median", "--rays", "random"}));
    CHECK(outcome.exit_code == 0);
    CHECK(outcome.err.empty());
    for (const char* part : {"gen:soup:2000: 2000 triangles; 5000 random rays on host", "Mrays/s", "ns/ray",
                             "vs binned-sah", "inner/ray", "median", "1.000x"}) {
        CHECK_THAT(outcome.out, Contains(part));
    }
}

TEST_CASE("trace names what is wrong with its input") {
    expect_failure({"gen:soup:10", "--rays", "mirror"}, {"mirror", "diffuse", "--rays"}, 2);
    expect_failure({"gen:soup:10", "--rays", "primary,"}, {"--rays"}, 2);
    expect_failure({"gen:soup:10", "--count", "0"}, {"--count"}, 2);
    expect_failure({"gen:soup:10", "--tracer", "pencil"}, {"--tracer"}, 2);
    expect_failure({"gen:soup:10", "--builder", "plocpq"}, {"plocpq", "plocpp"});
    expect_failure({"gen:soup:10", "--camera", "1,2,3"}, {"--camera", "1,2,3"});
    expect_failure({"gen:soup:10", "--up", "w"}, {"--up", "w", "-x"});
    expect_failure({"gen:soup:10", "--load-rays", missing_path("rays")}, {missing_path("rays")});
    expect_failure({"gen:soup:10", "--save-rays", missing_path("none/rays")}, {missing_path("none/rays")});
    expect_failure({"gen:soup:10", "gen:soup:20", "--save-rays", "rays"}, {"--save-rays", "one scene"});
    expect_failure({"gen:soup:10", "--rays", "ao,shadow", "--save-rays", "rays"}, {"--save-rays", "one kind"});
    expect_failure({"gen:soup:10", "--camera", "9,9,9,10,10,10"}, {"gen:soup:10", "diffuse", "--camera"});
    expect_failure({"gen:soup:0", "--rays", "random"}, {"gen:soup:0", "no surface"});
    expect_failure({missing_path("scene.obj")}, {missing_path("scene.obj")});
}

TEST_CASE("bench tells what rays cost where it is asked") {
    const Words words{"bench", "gen:city:2000", "--builders", "median,sbvh", "--runs", "1", "--rays"};
    const Outcome table = run_tool(words);
    CHECK(table.exit_code == 0);
    CHECK_THAT(table.out, Contains("ns/ray") && Contains("steps/ray"));
    Words with_json = words;
    with_json.insert(with_json.end(), {"--json", "-"});
    for (const ordered_json& result : ordered_json::parse(run_tool(with_json).out)["results"]) {
        CHECK(result["ns_per_ray"].get<double>() * result["mrays_per_s"].get<double>() == Approx(1000.0));
        CHECK(result["steps_per_ray"] > 1.0);
        CHECK(result["triangles_per_ray"] > 0.0);
        CHECK(result["ray_count"] > 200000);
    }
    CHECK_THAT(run_tool({"bench", "gen:city:2000", "--builders", "median", "--runs", "1"}).out, !Contains("ns/ray"));
    const Outcome sweep = run_tool({"bench", "gen:city:2000", "--rays", "--sweep", "radius"});
    CHECK(sweep.exit_code == 1);
    CHECK_THAT(sweep.err, Contains("--rays") && Contains("--sweep"));
}
