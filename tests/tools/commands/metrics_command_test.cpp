#include <catch2/catch.hpp>
#include <clbvh/builder.hpp>
#include <clbvh/eval/cost_fit.hpp>
#include <clbvh/eval/ray_sets.hpp>
#include <clbvh/io/scene.hpp>
#include <clbvh/metrics/epo.hpp>
#include <clbvh/metrics/lcv.hpp>
#include <clbvh/metrics/sah.hpp>
#include <clbvh/metrics/surface_ray_cost.hpp>
#include <clbvh/metrics/tree_statistics.hpp>
#include <clbvh/trace/binary_tracer.hpp>
#include <clbvh/trace/tracer.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

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

Outcome metrics(Words words, const Words& more = {}) {
    words.insert(words.begin(), "metrics");
    words.insert(words.end(), more.begin(), more.end());
    words.insert(words.end(), {"--count", "2000", "--runs", "1"});
    return run_tool(words, kNoDriver);
}

ordered_json json_of(Words words) {
    const Outcome outcome = metrics(std::move(words), {"--json", "-"});
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    CHECK(outcome.err.empty());
    return ordered_json::parse(outcome.out);
}

/// Of the results of one scene.
std::vector<TreeCost> costs_of(const ordered_json& results, const std::string& scene, const std::string& measurement) {
    std::vector<TreeCost> costs;
    for (const ordered_json& result : results) {
        if (result["scene"] == scene)
            costs.push_back({result["sah"], result["epo"], result["lcv"], result[measurement]});
    }
    return costs;
}

void check_fit(const ordered_json& json, const CostFit& fit) {
    CHECK(json["correlation"].get<double>() == Approx(fit.correlation).margin(1e-12));
    CHECK(json.value("alpha", 0.0) == Approx(fit.weights.alpha).margin(1e-12));
    CHECK(json.value("beta", 0.0) == Approx(fit.weights.beta).margin(1e-12));
}

}  // namespace

TEST_CASE("metrics tells of a tree and of its rays what the library says of them") {
    const ordered_json document = json_of({"gen:city:3000", "--builders", "sbvh,median", "--seed", "7"});
    CHECK(field_names(document) ==
          Words{"machine", "device", "profile", "rotate_degrees", "options", "results", "correlation"});
    const Mesh mesh = generate_scene("city", 3000);
    const ordered_json& results = document["results"];
    REQUIRE(results.size() == 2);
    std::vector<Ray> rays;
    for (const ordered_json& result : results) {
        const Bvh bvh = Builder(result["builder"].get<std::string>()).build(mesh);
        const TreeStatistics statistics = tree_statistics(bvh);
        CHECK(result["sah"] == sah_cost(bvh));
        CHECK(result["ray_cost"] == surface_ray_cost(bvh, mesh).cost);
        CHECK(result["epo"] == end_point_overlap(bvh, mesh));
        CHECK_FALSE(result.contains("epo_standard_error"));
        CHECK(result["epo_ms"].get<double>() > 0.0);
        CHECK(result["depth"] == statistics.depth());
        CHECK(result["leaves"] == statistics.leaves);
        CHECK(result["leaves_by_depth"] == statistics.leaves_by_depth);
        CHECK(result["leaves_by_size"] == statistics.leaves_by_size);
        CHECK(result["sibling_overlap"] == statistics.sibling_overlap);
        const Tracer tracer(bvh, mesh);
        if (rays.empty()) {
            const Camera camera = parse_camera(result["camera"].get<std::string>(), guess_up(mesh));
            rays = make_rays(RayKind::diffuse, mesh, closest_hits_of(tracer), camera, {2000, 7});
        }
        std::vector<Hit> hits(rays.size());
        std::vector<RayCounts> counts(rays.size());
        BinaryTracer(bvh, mesh).closest(rays, hits, counts);
        CHECK(result["ray_count"] == rays.size());
        CHECK(result["lcv"] == leaf_count_variability(counts));
        CHECK(result["steps_per_ray"] == mean_counts(counts).steps());
        CHECK(result["mismatches"] == 0);
        CHECK(result["ns_per_ray"].get<double>() > 0.0);
        CHECK(result["binary_ns_per_ray"].get<double>() > 0.0);
    }
    CHECK(results[0]["epo"] < results[1]["epo"]);
}

TEST_CASE("metrics predicts what it measured, by scene and over all") {
    const Words scenes{"gen:city:2000", "gen:soup:1000", "gen:sphere:1000"};
    Words words = scenes;
    words.insert(words.end(), {"--builders", "sbvh,median,binned-sah,aac-hq,locally-ordered", "--max-leaf", "4"});
    const ordered_json document = json_of(words);
    const ordered_json& correlation = document["correlation"];
    REQUIRE(correlation["scenes"].size() == 6);
    REQUIRE(correlation["pooled"].size() == 2);
    std::size_t next = 0;
    for (const std::string& scene : scenes) {
        for (const char* measurement : {"ns_per_ray", "binary_ns_per_ray"}) {
            const ordered_json& json = correlation["scenes"][next++];
            CHECK(json["scene"] == scene);
            CHECK(json["measurement"] == measurement);
            const std::vector<TreeCost> costs = costs_of(document["results"], scene, measurement);
            REQUIRE(costs.size() == 5);
            check_fit(json["sah"], fit_costs(costs, CostTerms::sah));
            check_fit(json["sah_epo"], fit_costs(costs, CostTerms::sah_epo));
            check_fit(json["sah_epo_lcv"], fit_costs(costs, CostTerms::sah_epo_lcv));
        }
    }
    for (const ordered_json& pool : correlation["pooled"]) {
        const std::string measurement = pool["measurement"];
        std::vector<std::vector<TreeCost>> all;
        double mean = 0.0, minimum = 1.0;
        for (const std::string& scene : scenes) {
            all.push_back(costs_of(document["results"], scene, measurement));
            const double quality = fit_costs(all.back(), CostTerms::sah_epo_lcv).correlation;
            mean += quality / 3;
            minimum = std::min(minimum, quality);
        }
        CHECK(pool["scenes"] == 3);
        CHECK(pool["sah_epo_lcv"]["mean"].get<double>() == Approx(mean).margin(1e-12));
        CHECK(pool["sah_epo_lcv"]["minimum"].get<double>() == Approx(minimum).margin(1e-12));
        check_fit(pool["sah_epo"]["shared"], fit_costs(all, CostTerms::sah_epo));
    }
}

TEST_CASE("metrics prints what people read") {
    const Outcome outcome =
        metrics({"gen:city:1000", "gen:soup:500", "--builders", "sbvh,median,binned-sah,aac-fast", "--rotate", "45"});
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    for (const char* word : {"EPO", "LCV", "overlap", "prims/leaf", "steps/ray", "binary", "SAH+EPO+LCV", "alpha",
                             "turned by 45 degrees", "gen:city:1000: 1000 triangles; ", "over 2 scenes", "shared"})
        CHECK_THAT(outcome.out, Contains(word));
    const Outcome few = metrics({"gen:city:1000", "--builders", "sbvh,median,binned-sah"});
    CHECK_THAT(few.out, Contains("no correlations: they need 4 builders or more") && !Contains("alpha"));
}

TEST_CASE("metrics estimates EPO from samples where it is told to") {
    const Words words{"gen:city:3000", "--builders", "median"};
    const double exact = json_of(words)["results"][0]["epo"];
    Words sampled = words;
    sampled.insert(sampled.end(), {"--epo-samples", "20000"});
    const ordered_json result = json_of(sampled)["results"][0];
    const double error = result["epo_standard_error"];
    CHECK(error > 0.0);
    CHECK(result["epo"] != exact);
    CHECK(std::abs(result["epo"].get<double>() - exact) < 5 * error);
    CHECK_THAT(metrics(sampled).out, Contains(" +- "));
}

TEST_CASE("metrics traces on a device where it is told to") {
    const Outcome outcome = run_tool({"metrics", "gen:city:1000", "--builders", "sbvh,lbvh", "--tracer", "device",
                                      "--count", "2000", "--runs", "1", "--json", "-"});
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    const ordered_json document = ordered_json::parse(outcome.out);
    check_device(document["device"]);
    for (const ordered_json& result : document["results"]) {
        CHECK(result["device"] == document["device"]["name"]);
        CHECK(result["binary_ns_per_ray"].get<double>() > 0.0);
        CHECK(result["mismatches"] == 0);
    }
}

TEST_CASE("metrics refuses what cannot be before it works") {
    const auto refused = [](const Words& words, int code, const std::string& part) {
        const Outcome outcome = metrics(words);
        INFO(outcome.err);
        CHECK(outcome.exit_code == code);
        CHECK(outcome.out.empty());
        CHECK_THAT(outcome.err, Contains(part));
    };
    refused({}, 2, "scene");
    for (const char* samples : {"0", "1", "-5", "many", "4294967297"})
        refused({"gen:soup:100", "--epo-samples", samples}, 2, "--epo-samples");
    refused({"gen:soup:100", "--rays", "primary,diffuse"}, 1, "one kind of rays");
    refused({"gen:soup:100", "--builders", "dream"}, 1, "dream");
    refused({"gen:stew"}, 1, "gen:stew");
    const ScratchFolder folder;
    const std::string broken = folder.path("broken.obj");
    std::ofstream(broken) << "v 0 0 zero\n";
    const Outcome outcome = metrics({"gen:soup:100", broken, "--builders", "median", "--json", "-"});
    CHECK(outcome.exit_code == 1);
    const ordered_json kept = ordered_json::parse(outcome.out);
    CHECK(kept["results"].size() == 1);
    CHECK_THAT(kept["incomplete"].get<std::string>(), Contains(broken));
}
