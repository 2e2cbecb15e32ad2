#include <fcntl.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <clbvh/builder.hpp>
#include <clbvh/catalog.hpp>
#include <clbvh/eval/cost_fit.hpp>
#include <clbvh/host/collapse.hpp>
#include <clbvh/io/scene.hpp>
#include <clbvh/metrics/epo.hpp>
#include <clbvh/metrics/sah.hpp>
#include <clbvh/metrics/tree_statistics.hpp>
#include <clbvh/optimize/rotate.hpp>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "aila2013/aila_builders.hpp"
#include "tools/result_fields.hpp"
#include "tools/scratch_folder.hpp"
#include "tools/tool_process.hpp"

using namespace clbvh;
using namespace clbvh::test;
using Catch::Matchers::Contains;
using nlohmann::ordered_json;

namespace {

using Words = std::vector<std::string>;

const Words kNoDriver{no_drivers()};
const Words kAilaIds{"lbvh", "bbvh", "sbvh", "agglo", "bittner", "hclimb", "anneal", "treelet", "streelet"};
const Words kFew{"--count", "2000", "--runs", "1", "--anneal-passes", "60"};

Outcome table(Words words, const Words& environment = {}) {
    words.insert(words.begin(), "table");
    words.insert(words.end(), kFew.begin(), kFew.end());
    return run_tool(words, environment);
}

ordered_json json_of(Words words, const Words& environment = {}) {
    words.insert(words.end(), {"--json", "-"});
    const Outcome outcome = table(std::move(words), environment);
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    CHECK(outcome.err.empty());
    return ordered_json::parse(outcome.out);
}

void check_fit(const ordered_json& json, const CostFit& fit) {
    CHECK(json["correlation"].get<double>() == Approx(fit.correlation).margin(1e-12));
    CHECK(json.value("alpha", 0.0) == Approx(fit.weights.alpha).margin(1e-12));
    CHECK(json.value("beta", 0.0) == Approx(fit.weights.beta).margin(1e-12));
}

/// The correlations of one measurement are those of the values that stand beside them.
void check_prediction(const ordered_json& prediction, const ordered_json& results) {
    const std::string measurement = prediction["measurement"];
    std::vector<TreeCost> costs;
    for (const ordered_json& result : results)
        costs.push_back({result["sah"], result["epo"], result["lcv"], result[measurement]});
    check_fit(prediction["sah"], fit_costs(costs, CostTerms::sah));
    check_fit(prediction["sah_epo"], fit_costs(costs, CostTerms::sah_epo));
    check_fit(prediction["sah_epo_lcv"], fit_costs(costs, CostTerms::sah_epo_lcv));
}

/// Each builder's tree as the library makes it, step by step.
std::map<std::string, Bvh> trees_by_hand(const Mesh& mesh) {
    BuildOptions merged;
    merged.max_leaf_size = 8;
    const Bvh lbvh = build(mesh, "lbvh");
    const Bvh merged_lbvh = collapse(lbvh);
    AnnealConfig annealing;
    annealing.length = 60;
    BuildOptions splitting = merged;
    splitting.optimizers = "treelet-split";
    return {{"lbvh", lbvh},
            {"bbvh", build(mesh, "sweep-sah", merged)},
            {"sbvh", build(mesh, "sbvh", merged)},
            {"agglo", build(mesh, "locally-ordered", merged)},
            {"bittner", collapse(optimize(lbvh, "reinsert-batches"))},
            {"hclimb", collapse(rotate(merged_lbvh))},
            {"anneal", collapse(anneal(merged_lbvh, annealing))},
            {"treelet", collapse(optimize(lbvh, "treelet"))},
            {"streelet", build(mesh, "lbvh", splitting)}};
}

}  // namespace

TEST_CASE("the nine builders are those of the paper, each by ids that the library knows") {
    Words ids;
    for (const tool::AilaBuilder& builder : tool::aila_builders()) {
        INFO(builder.title);
        ids.emplace_back(builder.id);
        CHECK(find_builder(builder.builder).id == builder.builder);
        CHECK_NOTHROW(check_optimizers(builder.optimizers));
    }
    CHECK(ids == kAilaIds);
}

TEST_CASE("table tells of each builder's tree what the library says of it") {
    const ordered_json document = json_of({"gen:city:3000"});
    CHECK(field_names(document) == Words{"machine", "device", "profile", "rotate_degrees", "options", "results",
                                         "anneal_passes", "correlation"});
    CHECK(document["anneal_passes"] == 60);
    check_device(document["device"]);
    const Mesh mesh = generate_scene("city", 3000);
    const std::map<std::string, Bvh> trees = trees_by_hand(mesh);
    const ordered_json& results = document["results"];
    REQUIRE(results.size() == kAilaIds.size());
    for (std::size_t i = 0; i < kAilaIds.size(); ++i) {
        const ordered_json& result = results[i];
        INFO(kAilaIds[i]);
        REQUIRE(result["builder"] == kAilaIds[i]);
        const Bvh& bvh = trees.at(kAilaIds[i]);
        const TreeStatistics statistics = tree_statistics(bvh);
        CHECK(result["sah"] == sah_cost(bvh));
        CHECK(result["epo"] == end_point_overlap(bvh, mesh));
        CHECK(result["leaves_by_size"] == statistics.leaves_by_size);
        CHECK(result["depth"] == statistics.depth());
        CHECK(result["mismatches"] == 0);
        CHECK(result["device_mismatches"] == 0);
        CHECK(result["cost_per_ray"].get<double>() ==
              Approx(1.2 * result["inner_per_ray"].get<double>() + result["triangles_per_ray"].get<double>()));
        for (const char* time :
             {"build_ms", "ns_per_ray", "binary_ns_per_ray", "device_ns_per_ray", "device_binary_ns_per_ray"})
            CHECK(result[time].get<double>() > 0.0);
    }
    CHECK(results[0]["leaves"] == mesh.triangles.size());
    CHECK(results[4]["made_by"] == "lbvh");
    CHECK(results[4]["optimizers"] == "reinsert-batches");
}

TEST_CASE("table predicts what it measured, on the host and on the device") {
    const ordered_json document = json_of({"gen:city:2000"});
    const ordered_json& scenes = document["correlation"]["scenes"];
    Words measurements;
    for (const ordered_json& prediction : scenes) {
        measurements.push_back(prediction["measurement"]);
        CHECK(prediction["scene"] == "gen:city:2000");
        check_prediction(prediction, document["results"]);
    }
    CHECK(measurements ==
          Words{"ns_per_ray", "binary_ns_per_ray", "device_ns_per_ray", "device_binary_ns_per_ray", "cost_per_ray"});
}

TEST_CASE("table says the same of a tree as metrics, and traces the same rays") {
    const ordered_json of_table = json_of({"gen:city:2000", "--builders", "bbvh,sbvh,agglo"}, kNoDriver);
    const Outcome outcome = run_tool({"metrics", "gen:city:2000", "--builders", "sweep-sah,sbvh,locally-ordered",
                                      "--max-leaf", "8", "--count", "2000", "--runs", "1", "--json", "-"},
                                     kNoDriver);
    REQUIRE(outcome.exit_code == 0);
    const ordered_json of_metrics = ordered_json::parse(outcome.out);
    REQUIRE(of_table["results"].size() == 3);
    for (std::size_t i = 0; i < 3; ++i) {
        for (const char* field : {"sah", "epo", "lcv", "ray_hash", "hits", "steps_per_ray", "leaves_by_depth"})
            CHECK(of_table["results"][i][field] == of_metrics["results"][i][field]);
    }
}

TEST_CASE("table lays builders out as the paper's columns") {
    const Outcome outcome = table({"gen:city:1000", "gen:soup:500", "--builders", "treelet,bbvh,hclimb,lbvh"});
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    std::size_t at = 0;
    for (const char* column : {"LBVH", "BBVH", "H.Climb", "Treelet", "with SAH", "SAH+EPO", "SAH+EPO+LCV"}) {
        at = outcome.out.find(column, at);
        INFO(column);
        REQUIRE(at != std::string::npos);
    }
    for (const char* word :
         {"gen:city:1000: 1000 triangles; ", "\nns/ray, host", "\nhost, binary", "\nns/ray, device", "\ncost/ray",
          "\nSAH ", "\nEPO ", "\nLCV ", "\nbuild ms", " a=", " b=", "over 2 scenes", "shared"})
        CHECK_THAT(outcome.out, Contains(word));
    CHECK_THAT(outcome.out, !Contains("Bittner"));
    const Outcome few = table({"gen:city:1000", "--builders", "lbvh,bbvh,sbvh"});
    CHECK_THAT(few.out, Contains("EPO") && !Contains("with SAH"));
}

TEST_CASE("table without a device traces on the host, and says so") {
    const Outcome outcome = table({"gen:city:1000", "--builders", "bbvh,sbvh,agglo"}, kNoDriver);
    CHECK(outcome.exit_code == 0);
    CHECK_THAT(outcome.out, Contains("rays are traced on the host only: ") && !Contains("ns/ray, device"));
    const ordered_json document = json_of({"gen:city:1000", "--builders", "agglo"}, kNoDriver);
    CHECK(document["device"].is_null());
    CHECK_FALSE(document["no_device"].get<std::string>().empty());
    CHECK_FALSE(document["results"][0].contains("device_ns_per_ray"));
}

TEST_CASE("table refuses what cannot be before it works") {
    const auto refused = [](const Words& words, int code, const std::string& part) {
        const Outcome outcome = table(words, kNoDriver);
        INFO(outcome.err);
        CHECK(outcome.exit_code == code);
        CHECK(outcome.out.empty());
        CHECK_THAT(outcome.err, Contains(part));
    };
    refused({}, 2, "scene");
    for (const char* passes : {"0", "-1", "some", "1000001"})
        refused({"gen:soup:100", "--anneal-passes", passes}, 2, "--anneal-passes");
    refused({"gen:soup:100", "--optimize", "rotate"}, 2, "--optimize");
    refused({"gen:soup:100", "--optimize-passes", "3"}, 2, "--optimize-passes");
    refused({"gen:soup:100", "--optimize-on", "device"}, 2, "--optimize-on");
    refused({"gen:soup:100", "--rays", "primary,diffuse"}, 1, "one kind of rays");
    refused({"gen:soup:100", "--builders", "bbvh,dream"}, 1, "'dream'");
    refused({"gen:soup:100", "--builders", ""}, 1, "unknown builder ''");
    refused({"gen:soup:100", "--presplit"}, 1, "--presplit: STreelet");
    refused({"gen:soup:100", "--max-leaf", "65"}, 1, "--max-leaf");
    refused({"gen:stew", "--builders", "bbvh"}, 1, "gen:stew");
    refused({"gen:soup:100"}, 1, "--builders bbvh,sbvh,agglo needs no device");
    refused({"gen:soup:100", "--builders", "bbvh", "--device", "gpu"}, 1, "");
}

TEST_CASE("table keeps the scenes before one that cannot be read") {
    const ScratchFolder folder;
    const std::string broken = folder.path("broken.obj");
    std::ofstream(broken) << "v 0 0 zero\n";
    const Outcome outcome = table({"gen:soup:100", broken, "--builders", "bbvh", "--json", "-"}, kNoDriver);
    CHECK(outcome.exit_code == 1);
    const ordered_json kept = ordered_json::parse(outcome.out);
    CHECK(kept["results"].size() == 1);
    CHECK_THAT(kept["incomplete"].get<std::string>(), Contains(broken));
}

TEST_CASE("Ctrl-C in a later scene of a table keeps the earlier ones, and ends annealing soon") {
    const ScratchFolder folder;
    const std::string text = folder.path("table.txt");
    const std::string json = folder.path("table.json");
    const int out = open(text.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
    REQUIRE(out >= 0);
    ToolProcess tool({"table", "gen:soup:50", "gen:soup:100000", "--builders", "anneal", "--anneal-passes", "100000",
                      "--count", "1000", "--runs", "1", "--json", json},
                     {}, -1, out);
    close(out);
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (read_text(text).find("build ms") == std::string::npos && std::chrono::steady_clock::now() < deadline)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    tool.interrupt();
    const Outcome outcome = tool.wait();
    CHECK(outcome.exit_code == 130);
    CHECK(outcome.err == "clbvh: cancelled\n");
    const auto document = nlohmann::json::parse(read_text(json));
    CHECK(document["incomplete"] == "interrupted");
    REQUIRE(document["results"].size() == 1);
    CHECK(document["results"][0]["scene"] == "gen:soup:50");
}
