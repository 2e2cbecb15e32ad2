#include <algorithm>
#include <catch2/catch.hpp>
#include <clbvh/catalog.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
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

/// Which line is a scene's header, where every builder could run: the machine, a blank line and the scene stand above.
constexpr std::size_t kHeader = 3;

const Words kNoDriver{no_drivers()};

/// The document of `bench` with one run of each builder.
ordered_json bench(Words arguments, const Words& environment = {}) {
    arguments.insert(arguments.begin(), "bench");
    arguments.insert(arguments.end(), {"--runs", "1", "--json", "-"});
    const Outcome outcome = run_tool(arguments, environment);
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    return ordered_json::parse(outcome.out);
}

/// check_result, with what every result of `bench` has behind `extra`.
void check_bench_result(const ordered_json& result, Words extra) {
    extra.emplace_back("native_sort_ms");
    if (result["kind"] == "device") extra.emplace_back("copy_gb_per_s");
    check_result(result, extra);
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
    CHECK(field_names(document) == Words{"machine", "device", "profile", "rotate_degrees", "options", "results"});
    check_options(document["options"]);
    check_device(document["device"]);
    const ordered_json& results = document["results"];
    REQUIRE(results.size() == 2 * builders().size());
    for (std::size_t i = 0; i < results.size(); ++i) {
        check_bench_result(results[i], {"valid"});
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
    const Outcome outcome = run_tool({"bench", "gen:soup:1000", "--builders", "lbvh, plocpp ,lbvh", "--runs", "1",
                                      "--radius", "4", "--shape", "group", "--no-validate", "--json", "-"});
    REQUIRE(outcome.exit_code == 0);
    const ordered_json results = ordered_json::parse(outcome.out)["results"];
    REQUIRE(results.size() == 2);
    CHECK(results[0]["builder"] == "lbvh");
    CHECK(results[1]["builder"] == "plocpp");
    CHECK(results[1]["radius"] == 4);
    for (const ordered_json& result : results) {
        check_bench_result(result, {});
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
    for (const char* column : {"median ms", "min ms", "Mtris/s", "vs ploc", "x sort", "SAH", "SAH/binned-sah",
                               "ray cost", "depth", "leaves", "prims/leaf", "bytes/prim", "valid"}) {
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
    for (std::size_t i = kHeader + 1; i <= kHeader + builders().size(); ++i)
        CHECK(lines.at(i).size() == lines.at(kHeader).size());
}

TEST_CASE("bench says where the SAH cost and the cost of rays disagree") {
    const auto notes = [](const std::string& code) {
        const Outcome outcome = run_tool({"bench", "gen:outlier:1000000:8000", "--builders", "lbvh,binned-sah",
                                          "--runs", "1", "--morton", code, "--max-leaf", "8"});
        REQUIRE(outcome.exit_code == 0);
        return count_lines_that_start_with(outcome.out, "note: rays from surfaces cost ");
    };
    CHECK(notes("xyz") == 1);
    CHECK(notes("cubic") == 0);
}

TEST_CASE("bench compares with what ran") {
    const auto table_of = [](const std::string& list) {
        const Outcome outcome = run_tool({"bench", "gen:soup:1000", "--builders", list, "--runs", "1"});
        REQUIRE(outcome.exit_code == 0);
        return lines_of(outcome.out);
    };
    CHECK_THAT(table_of("lbvh").at(kHeader), !Contains("vs ") && !Contains("SAH/"));
    CHECK_THAT(table_of("lbvh,ploc").at(kHeader), Contains("vs ploc") && Contains("SAH/ploc"));
    CHECK_THAT(table_of("median,binned-sah").at(kHeader), Contains("vs binned-sah") && Contains("SAH/binned-sah"));
    const Words both = table_of("binned-sah,ploc");
    CHECK_THAT(both.at(kHeader), Contains("vs ploc") && Contains("SAH/binned-sah"));
    CHECK_THAT(both.at(kHeader + 1), StartsWith("binned-sah ") && Contains(" 1.0000 "));
    CHECK_THAT(both.at(kHeader + 2), StartsWith("ploc ") && Contains(" 1.00x "));
}

TEST_CASE("groups stand for their builders, each once, beside ids") {
    for (const auto& [list, first, kinds] :
         {std::tuple{"host", "", Words{"host"}}, std::tuple{"device", "", Words{"device"}},
          std::tuple{"lbvh,host", "lbvh", Words{"host"}},
          std::tuple{"median,all", "median", Words{"host", "device"}}}) {
        INFO(list);
        Words expected;
        if (*first != 0) expected.emplace_back(first);
        for (const BuilderInfo& builder : builders()) {
            const std::string kind = builder.kind == BuilderKind::host ? "host" : "device";
            const bool chosen = std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
            if (chosen && builder.id != first) expected.emplace_back(builder.id);
        }
        const ordered_json results = bench({"gen:soup:500", "--builders", list})["results"];
        Words names;
        for (const ordered_json& result : results)
            names.push_back(result["builder"]);
        CHECK(names == expected);
    }
}

TEST_CASE("presets stand beside builders, under their own names") {
    const ordered_json results = bench({"gen:city:2000", "--builders", "binned-sah,high,presets"})["results"];
    std::vector<std::string> ids;
    for (const ordered_json& result : results)
        ids.push_back(result["builder"]);
    CHECK(ids == std::vector<std::string>{"binned-sah", "high", "fast", "balanced", "highest"});
    CHECK(results[1]["sah"] < results[0]["sah"]);
    CHECK(results[0]["kind"] == "host");
    CHECK(results[2]["kind"] == "device");
}

TEST_CASE("bench tells of each result what it ran with, whoever set it") {
    const ordered_json document =
        bench({"gen:city:2000", "--builders", "binned-sah,presets", "--optimize-passes", "2"});
    CHECK(document["options"]["optimizers"].get<std::string>().empty());
    CHECK(document["results"][0]["optimizers"].get<std::string>().empty());
    CHECK(document["results"][0]["max_leaf_size"] == 0);
    REQUIRE(document["results"].size() == presets().size() + 1);
    for (std::size_t i = 0; i < presets().size(); ++i) {
        const ordered_json& result = document["results"][i + 1];
        CHECK(result["builder"] == presets()[i].id);
        CHECK(result["optimizers"] == presets()[i].optimizers);
        CHECK(result["optimize_passes"] == 2);
        CHECK(result["max_leaf_size"] == presets()[i].max_leaf_size);
        CHECK(result["split_quota"] == 0.0);
    }
    const ordered_json splitting =
        bench({"gen:city:500", "--builders", "binned-sah", "--optimize", "treelet-split"})["results"][0];
    CHECK(splitting["optimizers"] == "treelet-split");
    CHECK(splitting["split_quota"] == 0.3);
}

TEST_CASE("without a device, bench runs the host builders and says why no others") {
    const ordered_json document = bench({"gen:soup:1000"}, kNoDriver);
    CHECK(field_names(document) ==
          Words{"machine", "device", "profile", "rotate_degrees", "options", "results", "unavailable"});
    CHECK(document["device"].is_null());
    std::size_t ran = 0;
    std::size_t unavailable = 0;
    for (const BuilderInfo& builder : builders()) {
        if (builder.kind == BuilderKind::host) {
            CHECK(document["results"].at(ran)["builder"] == builder.id);
            check_bench_result(document["results"][ran++], {"valid"});
        } else {
            const ordered_json& entry = document["unavailable"].at(unavailable++);
            CHECK(entry["builder"] == builder.id);
            CHECK_THAT(entry["reason"].get<std::string>(), Contains("pocl-opencl-icd"));
        }
    }
    CHECK(document["results"].size() == ran);
    CHECK(document["unavailable"].size() == unavailable);
    const Outcome text = run_tool({"bench", "gen:soup:1000", "--runs", "1"}, kNoDriver);
    CHECK(text.exit_code == 0);
    CHECK_THAT(text.out, Contains("not available: ploc, ") && Contains("pocl-opencl-icd") &&
                             Contains("\nbinned-sah ") && !Contains("vs ploc"));
}

TEST_CASE("without a device, a device builder that is asked for is an error") {
    for (const char* list : {"lbvh", "binned-sah,lbvh", "device", "all,ploc"}) {
        INFO(list);
        const Outcome outcome = run_tool({"bench", "gen:soup:10", "--builders", list}, kNoDriver);
        CHECK(outcome.exit_code == 1);
        CHECK(outcome.out.empty());
        CHECK_THAT(outcome.err, Contains("pocl-opencl-icd") && Contains("--builders host needs no device"));
    }
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
    expect_failure({"gen:soup:10", "--builders", "quick"}, "groups are: all, host, device, presets");
    expect_failure({"gen:soup:10", "--builders", "median,embree-sbvh"}, "--peers");
    expect_failure({"gen:soup:10", "--builders", "ploc,"}, "plocpp-two-level");
    expect_failure({"gen:soup:10", "--radius", "33"}, "radius is 33");
    expect_failure({"gen:soup:10", "--device", "no such device"}, "no such device");
    expect_failure({missing_path("scene.obj")}, missing_path("scene.obj"));
    expect_failure({"gen:soup:10", "--json", folder.path("none/x.json")}, "none/x.json");
}

TEST_CASE("bench finds a scene that cannot be opened before it times any") {
    const ScratchFolder folder;
    const std::string present = folder.path("present.obj");
    std::ofstream(present) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    CHECK(bench({present, "gen:soup:10:3", "--builders", "median"})["results"].size() == 2);
    for (const std::string& scene :
         {folder.path("absent.obj"), folder.path(""), std::string("/dev/null"), std::string("gen:stew"),
          std::string("gen:soup:many"), std::string("gen:soup:"), std::string("gen:soup:1:"),
          std::string("gen:soup:1:x"), std::string("gen:soup:1:2:3"), std::string("gen:soup:1073741824")}) {
        INFO(scene);
        const std::string json = folder.path("bench.json");
        const Outcome outcome =
            run_tool({"bench", "gen:soup:100", scene, "gen:broth", "--builders", "median", "--json", json});
        INFO(outcome.err);
        CHECK(outcome.exit_code == 1);
        CHECK(outcome.out.empty());
        CHECK_THAT(outcome.err, Contains(scene) && !Contains("broth"));
        CHECK(folder.file_count() == 1);
    }
}

TEST_CASE("a benchmark that fails keeps what it has measured") {
    const ScratchFolder folder;
    const std::string broken = folder.path("broken.obj");
    std::ofstream(broken) << "v 0 0 zero\n";
    const Outcome outcome =
        run_tool({"bench", "gen:soup:100", broken, "--builders", "median", "--runs", "1", "--json", "-"}, kNoDriver);
    CHECK(outcome.exit_code == 1);
    CHECK_THAT(outcome.err, Contains(broken));
    const ordered_json document = ordered_json::parse(outcome.out);
    CHECK(field_names(document) ==
          Words{"machine", "device", "profile", "rotate_degrees", "options", "results", "incomplete"});
    REQUIRE(document["results"].size() == 1);
    check_bench_result(document["results"][0], {"valid"});
    CHECK_THAT(document["incomplete"].get<std::string>(), Contains(broken));
}

TEST_CASE("the title of bench's table says what leaves have in common") {
    const auto title = [](Words more) {
        Words arguments{"bench", "gen:soup:100", "--runs", "1", "--no-validate"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const Outcome outcome = run_tool(arguments, kNoDriver);
        REQUIRE(outcome.exit_code == 0);
        return lines_of(outcome.out).at(kHeader - 1);
    };
    const Catch::StdString::ContainsMatcher own = Contains("100 triangles; leaves as each builder makes them; ");
    CHECK_THAT(title({"--builders", "median,binned-sah"}), own);
    CHECK_THAT(title({"--builders", "median,binned-sah", "--max-leaf", "8"}),
               Contains("100 triangles; leaves of up to 8 primitives; "));
    // A preset of its own leaf size, and a builder of another.
    CHECK_THAT(title({"--builders", "binned-sah,highest"}), own);
}

TEST_CASE("one thread is no plural") {
    const Outcome outcome =
        run_tool({"bench", "gen:soup:100", "--builders", "median", "--runs", "1", "--threads", "1"}, kNoDriver);
    REQUIRE(outcome.exit_code == 0);
    CHECK_THAT(lines_of(outcome.out).at(kHeader - 1), Catch::Matchers::EndsWith("host builders on 1 thread"));
}
