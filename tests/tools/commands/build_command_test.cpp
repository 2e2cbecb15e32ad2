#include <catch2/catch.hpp>
#include <clbvh/catalog.hpp>
#include <clbvh/core/validate.hpp>
#include <clbvh/io/bvh_file.hpp>
#include <clbvh/io/layout_file.hpp>
#include <clbvh/io/scene.hpp>
#include <clbvh/metrics/sah.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <utility>
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

const Words kNoDriver{no_drivers()};

/// Runs `build` with JSON on standard output, and returns the one result.
ordered_json result_of(Words arguments, const Words& environment = {}) {
    arguments.insert(arguments.begin(), "build");
    arguments.insert(arguments.end(), {"--json", "-"});
    const Outcome outcome = run_tool(arguments, environment);
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    CHECK(outcome.err.empty());
    const ordered_json document = ordered_json::parse(outcome.out);
    CHECK(field_names(document) == Words{"machine", "device", "profile", "rotate_degrees", "options", "results"});
    check_options(document["options"]);
    REQUIRE(document["results"].size() == 1);
    const ordered_json& result = document["results"][0];
    if (result["kind"] == "device") {
        check_device(document["device"]);
    } else {
        CHECK(document["device"].is_null());
    }
    return result;
}

void expect_failure(Words arguments, const Words& parts, const Words& environment = {}, int exit_code = 1) {
    arguments.insert(arguments.begin(), "build");
    arguments.insert(arguments.end(), {"--json", "-"});
    const Outcome outcome = run_tool(arguments, environment);
    INFO(outcome.err);
    CHECK(outcome.exit_code == exit_code);
    CHECK(outcome.out.empty());
    CHECK_THAT(outcome.err, StartsWith("clbvh: error: "));
    for (const std::string& part : parts)
        CHECK_THAT(outcome.err, Contains(part));
}

}  // namespace

TEST_CASE("build describes what every builder did") {
    for (const BuilderInfo& builder : builders()) {
        const bool reads_radius = reads_option(builder.id, "ploc.search_radius");
        Words words{"gen:soup:3000:7", "--builder", std::string(builder.id), "--validate"};
        if (reads_radius) words.insert(words.end(), {"--radius", "8"});
        const ordered_json result = result_of(words);
        check_result(result, {"valid", "first_build_ms"});
        CHECK(result["scene"] == "gen:soup:3000:7");
        CHECK(result["triangles"] == 3000);
        CHECK(result["builder"] == builder.id);
        CHECK(result["kind"] == (builder.kind == BuilderKind::device ? "device" : "host"));
        if (builder.kind == BuilderKind::device) CHECK(result["radius"] == (reads_radius ? 8 : 0));
        CHECK(result["valid"] == true);
        CHECK(result["first_build_ms"].get<double>() > 0.0);
    }
}

TEST_CASE("build says nothing of validity unless asked") {
    const ordered_json unasked = result_of({"gen:city:2000"});
    check_result(unasked, {"first_build_ms"});
    CHECK(unasked["builder"] == "plocpp");
    CHECK(unasked["radius"] == 16);
    const ordered_json asked = result_of({"gen:city:2000", "--validate"});
    for (const char* field : {"sah", "depth", "nodes", "leaves"})
        CHECK(unasked[field] == asked[field]);
}

TEST_CASE("build obeys the options of a build") {
    CHECK(result_of({"gen:soup:3000", "--shape", "group"})["shape"] == "group");
    CHECK(result_of({"gen:soup:3000", "--shape", "lane"})["shape"] == "lane");
    const auto sah = [](const Words& options) {
        Words words{"gen:clustered:3000"};
        words.insert(words.end(), options.begin(), options.end());
        return result_of(words)["sah"].get<double>();
    };
    CHECK(sah({"--radius", "1"}) > sah({"--radius", "32"}));
    CHECK(sah({"--morton", "xyz"}) != sah({"--morton", "extended"}));
    const auto iterations = [](const std::string& threshold) {
        return result_of({"gen:soup:20000", "--threshold", threshold})["iterations"].get<int>();
    };
    CHECK(iterations("64") > iterations("16384"));
}

TEST_CASE("build obeys the options of host builders") {
    const auto result_with = [](const Words& options) {
        Words words{"gen:clustered:3000", "--builder", "binned-sah"};
        words.insert(words.end(), options.begin(), options.end());
        return result_of(words);
    };
    const ordered_json plain = result_with({});
    CHECK(plain["leaves"] < plain["triangles"]);
    CHECK(result_with({"--max-leaf", "1"})["leaves"] == plain["triangles"]);
    CHECK(result_with({"--bins", "2"})["sah"] > plain["sah"]);
    CHECK(result_with({"--longest-axis"})["sah"] > plain["sah"]);
    CHECK(result_with({"--inner-cost", "10"})["leaves"] < plain["leaves"]);
    CHECK(result_with({"--primitive-cost", "10"})["leaves"] > plain["leaves"]);
    const ordered_json single = result_with({"--threads", "1"});
    CHECK(single["threads"] == 1);
    for (const char* field : {"sah", "depth", "nodes", "leaves"})
        CHECK(single[field] == plain[field]);
}

TEST_CASE("build obeys the options for trees of all builders") {
    for (const char* builder : {"plocpp", "median"}) {
        INFO(builder);
        const Words words{"gen:hair:3000", "--builder", builder, "--validate"};
        const auto result_with = [&words](const Words& options) {
            Words all = words;
            all.insert(all.end(), options.begin(), options.end());
            return result_of(all);
        };
        const ordered_json plain = result_with({});
        CHECK(plain["references"] == 3000);
        const ordered_json single = result_with({"--max-leaf", "1"});
        CHECK(single["leaves"] == 3000);
        CHECK(result_with({"--max-leaf", "4"})["sah"] < single["sah"]);
        const ordered_json split = result_with({"--presplit"});
        CHECK(split["valid"] == true);
        CHECK(split["references"] > 3000);
        CHECK(result_with({"--presplit", "1"})["references"] == 3000);
    }
}

TEST_CASE("build improves trees by what --optimize names, and names what it does not know") {
    for (const std::string builder : {"lbvh", "sweep-sah"}) {
        const Words plain{"gen:clustered:5000", "--builder", builder, "--max-leaf", "4"};
        Words better = plain;
        better.insert(better.end(), {"--optimize", "treelet,reinsert", "--validate"});
        const ordered_json result = result_of(better);
        CHECK(result["valid"] == true);
        CHECK(result["sah"].get<double>() < 0.97 * result_of(plain)["sah"].get<double>());
    }
    const Outcome outcome = run_tool({"build", "gen:soup:100", "--optimize", "rotate,none"});
    CHECK(outcome.exit_code == 1);
    CHECK_THAT(outcome.err, Contains("--optimize: unknown optimizer 'none'"));
}

TEST_CASE("build obeys the options of spatial splits") {
    const auto references = [](const Words& options) {
        Words words{"gen:hair:3000", "--builder", "sbvh"};
        words.insert(words.end(), options.begin(), options.end());
        return result_of(words)["references"].get<int>();
    };
    CHECK(references({}) > 3000);
    CHECK(references({"--budget", "1"}) == 3000);
    CHECK(references({"--alpha", "1"}) < references({}));
    CHECK(references({"--overlap", "0.9"}) < references({}));
}

TEST_CASE("without a device, host builders build and device builders say what to install") {
    for (const BuilderInfo& builder : builders()) {
        const Words words{"gen:soup:1000", "--builder", std::string(builder.id), "--validate"};
        INFO(builder.id);
        if (builder.kind == BuilderKind::host) {
            CHECK(result_of(words, kNoDriver)["valid"] == true);
        } else {
            expect_failure(words, {"pocl-opencl-icd", "--builder binned-sah", "needs no device"}, kNoDriver);
        }
    }
}

TEST_CASE("tuning does not change the tree's size") {
    for (const Words& tuning :
         {Words{"--encoding", "bits64", "--search", "scan", "--shape", "group"},
          Words{"--encoding", "bits32", "--search", "symmetric", "--shape", "group"},
          Words{"--chunk", "128", "--shape", "lane"}, Words{"--work-group", "128", "--shape", "group"},
          Words{"--ranges", "5", "--builder", "plocpp-two-level"}}) {
        Words words{"gen:hair:3000", "--validate"};
        words.insert(words.end(), tuning.begin(), tuning.end());
        CHECK(result_of(words)["valid"] == true);
    }
}

TEST_CASE("build prints a summary for people") {
    const Outcome outcome = run_tool({"build", "gen:soup:3000", "--validate"});
    CHECK(outcome.exit_code == 0);
    CHECK(outcome.err.empty());
    for (const char* part : {"gen:soup:3000: 3000 triangles", "plocpp", "radius 16", "Mtris/s", "SAH", "depth",
                             "5999 nodes, 3000 leaves", "valid", "bounds", "morton", "sort", "cluster", "root"}) {
        CHECK_THAT(outcome.out, Contains(part));
    }
}

TEST_CASE("the summary of a host builder speaks of no device") {
    const Outcome outcome = run_tool({"build", "gen:soup:3000", "--builder", "median", "--threads", "1"}, kNoDriver);
    CHECK(outcome.exit_code == 0);
    CHECK(outcome.err.empty());
    CHECK_THAT(outcome.out, Contains("median, on the host, 1 thread\n") && Contains("Mtris/s") && Contains("stage"));
    for (const char* word : {"device", "shape", "launches", "iterations", "kernels"})
        CHECK_THAT(outcome.out, !Contains(word));
}

TEST_CASE("the file that build writes is the tree that it describes") {
    const ScratchFolder folder;
    const std::string path = folder.path("tree.bvh");
    const ordered_json result = result_of({"gen:terrain:3000", "-o", path});
    const Bvh bvh = read_bvh(path);
    const ValidationReport report = validate(bvh, load_scene("gen:terrain:3000"));
    INFO(report.error);
    CHECK(report.valid);
    CHECK(result["depth"] == report.depth);
    CHECK(result["nodes"] == report.nodes);
    CHECK(result["leaves"] == report.leaves);
    CHECK(result["sah"].get<double>() == Approx(sah_cost(bvh)));
    CHECK(folder.file_count() == 1);
}

TEST_CASE("build names what is wrong with its input") {
    expect_failure({"gen:soup:10", "--builder", "plocpq"}, {"plocpq", "plocpp", "lbvh"});
    expect_failure({"gen:soup:10", "--builder", "embree-sbvh"}, {"embree-sbvh", "--peers", "plocpp"});
    expect_failure({"gen:stew"}, {"stew", "soup"});
    expect_failure({"gen:soup:many"}, {"many"});
    expect_failure({missing_path("scene.obj")}, {missing_path("scene.obj")});
    expect_failure({"gen:soup:10", "--radius", "0"}, {"radius is 0", "1 to 32"});
    expect_failure({"gen:soup:10", "--radius", "33"}, {"radius is 33", "1 to 32"});
    for (const auto& [option, value] :
         {std::pair{"--max-leaf", "65"}, std::pair{"--presplit", "41"}, std::pair{"--split-quota", "5"},
          std::pair{"--inner-cost", "0"}, std::pair{"--primitive-cost", "-1"}, std::pair{"--threads", "1025"},
          std::pair{"--bins", "1"}, std::pair{"--alpha", "1.5"}, std::pair{"--overlap", "1.5"},
          std::pair{"--budget", "0.5"}, std::pair{"--threshold", "1"}}) {
        expect_failure({"gen:soup:10", option, value}, {std::string(option) + ": ", std::string(" is ") + value});
    }
    expect_failure({"gen:soup:10", "--device", "no such device"}, {"no such device"});
}

TEST_CASE("build finds an output that cannot be written before it loads the scene") {
    const ScratchFolder folder;
    expect_failure({missing_path("scene.obj"), "-o", folder.path("none/tree.bvh")}, {"none/tree.bvh"});
    expect_failure({missing_path("scene.obj"), "-o", folder.path("")}, {"not a regular file"});
    expect_failure({"gen:soup:10", "-o", "/dev/null"}, {"/dev/null", "not a regular file"});
    CHECK(folder.file_count() == 0);
}

TEST_CASE("scenes of no and of one triangle are built") {
    const ordered_json empty = result_of({"gen:soup:0", "--validate"});
    CHECK(empty["valid"] == true);
    CHECK(empty["nodes"] == 0);
    CHECK(empty["sah"] == 0.0);
    CHECK(empty["mtris_per_s"] == 0.0);
    CHECK(empty["peak_bytes_per_primitive"] == 0.0);
    const ordered_json one = result_of({"gen:soup:1", "--validate"});
    CHECK(one["valid"] == true);
    CHECK(one["nodes"] == 1);
}

TEST_CASE("build reports the file that it wrote") {
    const ScratchFolder folder;
    const std::string path = folder.path("tree.bvh");
    const Words words{"build", "gen:soup:100", "--builder", "median"};
    CHECK_THAT(run_tool(words).out, !Contains("\noutput "));
    Words with_output = words;
    with_output.insert(with_output.end(), {"-o", path});
    CHECK_THAT(run_tool(with_output).out, Contains("\noutput     " + path + "\n"));
    CHECK(folder.file_count() == 1);
}

TEST_CASE("build writes layouts, and dump says what they hold") {
    const ScratchFolder folder;
    const std::string path = folder.path("layout");
    for (const auto& [kind, elements] :
         {std::pair{"wide8", "blocks"}, std::pair{"wide4", "blocks"}, std::pair{"compressed8", "triangles"},
          std::pair{"pair", "primitive_ids"}, std::pair{"skip", "primitive_ids"}}) {
        const Outcome built =
            run_tool({"build", "gen:soup:100", "--builder", "sbvh", "--validate", "--layout", kind, "-o", path});
        INFO(built.err);
        REQUIRE(built.exit_code == 0);
        CHECK_THAT(built.out, Contains("\noutput     " + path + ", " + kind + "\n"));
        const ordered_json shown = ordered_json::parse(run_tool({"dump", path, "--json"}).out);
        CHECK(field_names(shown) ==
              Words{"layout", "primitive_count", "split_references", "depth", "nodes", elements, "bytes"});
        CHECK(shown["layout"] == kind);
        CHECK(shown["primitive_count"] == 100);
        CHECK(shown["split_references"] == true);
        CHECK(shown["bytes"] == std::filesystem::file_size(path));
    }
    const auto nodes_with = [&](const char* opening) {
        const Words words{"build", "gen:city:5000", "--builder", "median", "--layout",
                          "wide8", "--opening",     opening,     "-o",     path};
        REQUIRE(run_tool(words).exit_code == 0);
        return read_layout_info(path).node_count;
    };
    CHECK(nodes_with("least-cost") < nodes_with("largest-first"));
    expect_failure({"gen:soup:10", "--layout", "wide8"}, {"--output"}, {}, 2);
    const Outcome unread = run_tool({"build", "gen:soup:10", "--builder", "median", "--opening", "least-cost"});
    CHECK(unread.exit_code == 0);
    CHECK(unread.err == "clbvh: note: --opening changes nothing here without --layout\n");
    expect_failure({"gen:soup:10", "--layout", "wide8", "--opening", "any", "-o", path}, {"any", "least-cost"}, {}, 2);
    expect_failure({"gen:soup:10", "--layout", "wide16", "-o", path}, {"wide16"}, {}, 2);
}

TEST_CASE("build's JSON holds the options that were in force") {
    const auto options_with = [](const Words& options) {
        Words words{"build", "gen:soup:100", "--builder", "median", "--json", "-"};
        words.insert(words.end(), options.begin(), options.end());
        return ordered_json::parse(run_tool(words).out)["options"];
    };
    const ordered_json plain = options_with({});
    CHECK(plain["inner_cost"].dump() == "1.2");
    CHECK(plain["sbvh.alpha"].dump() == "1e-05");
    CHECK(plain["max_leaf_size"] == 0);
    CHECK(plain["device.morton_code"] == "cubic");
    const std::vector<std::tuple<const char*, ordered_json, Words>> cases{
        {"inner_cost", 2.5, {"--inner-cost", "2.5"}},
        {"primitive_cost", 0.5, {"--primitive-cost", "0.5"}},
        {"max_leaf_size", 7, {"--max-leaf", "7"}},
        {"binned_sah.longest_axis_only", true, {"--longest-axis"}},
        {"sbvh.alpha", 0.25, {"--alpha", "0.25"}},
        {"sbvh.overlap", 0.5, {"--overlap", "0.5"}},
        {"ray_cost", true, {"--ray-cost"}},
        {"opening", "least-cost", {"--opening", "least-cost"}},
        {"sbvh.reference_budget", 1.5, {"--budget", "1.5"}},
        {"presplit_level", 14, {"--presplit"}},
        {"split_quota", 0.3, {"--split-quota"}},
        {"optimizers", "rotate", {"--optimize", "rotate"}},
        {"optimize_passes", 3, {"--optimize-passes", "3"}},
        {"optimize_on", "device", {"--optimize-on", "device"}},
        {"thread_count", 1, {"--threads", "1"}},
        {"ploc.search_radius", 9, {"--radius", "9"}},
        {"device.shape", "lane", {"--shape", "lane"}},
        {"device.sort_shape", "group", {"--sort-shape", "group"}},
        {"device.morton_code", "extended", {"--morton", "extended"}},
        {"device.code_bits", 33, {"--code-bits", "33"}},
        {"ploc.neighbour_encoding", "bits64", {"--encoding", "bits64"}},
        {"ploc.neighbour_search", "scan", {"--search", "scan"}},
        {"ploc.single_group_threshold", 512, {"--threshold", "512"}},
        {"ploc.chunk_size", 128, {"--chunk", "128"}},
        {"ploc.work_group_size", 64, {"--work-group", "64"}},
        {"ploc.range_count", 3, {"--ranges", "3"}},
        {"hploc.search_radius", 7, {"--hploc-radius", "7"}},
        {"hploc.cluster_limit", 8, {"--cluster-limit", "8"}},
        {"hploc.small_range", 32, {"--small-range", "32"}},
        {"hploc.small_limit", 4, {"--small-limit", "4"}},
        {"hploc.merge_pairs", false, {"--merge-pairs", "off"}},
        {"hploc.leaf_size", 4, {"--leaf-size", "4"}},
    };
    const ordered_json bins = options_with({"--bins", "9"});
    for (const char* const name : {"binned_sah.bin_count", "sbvh.bin_count", "sbvh.spatial_bin_count"})
        CHECK(bins.at(name) == 9);
    CHECK(cases.size() + 3 == plain.size());
    for (const auto& [name, value, words] : cases) {
        INFO(name);
        ordered_json expected = plain;
        expected.at(name) = value;
        CHECK(options_with(words) == expected);
    }
}

TEST_CASE("a build on more threads than there are runs on those there are, and says nothing else") {
    const ordered_json all = result_of({"gen:soup:1000", "--builder", "median"}, kNoDriver);
    const ordered_json many = result_of({"gen:soup:1000", "--builder", "median", "--threads", "1024"}, kNoDriver);
    CHECK(many["threads"] == all["threads"]);
}
