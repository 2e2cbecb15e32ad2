// The numbers of bench/published.json beside the papers' own tables.
#include <array>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "aila2013/aila_builders.hpp"
#include "support/published_costs.hpp"
#include "tools/scratch_folder.hpp"

using namespace clbvh;
using namespace clbvh::test;
using nlohmann::json;

namespace {

using Costs = std::array<double, kPublishedBuilders>;

json published() {
    return json::parse(read_text(CLBVH_BENCH "/published.json"));
}

/// Over the scenes, of each builder's value over LBVH's.
template <typename Values>
Costs mean_relative(const Values& values_of) {
    Costs means{};
    for (const PublishedScene& scene : kPublishedScenes) {
        const Costs& values = values_of(scene);
        for (std::size_t i = 0; i < means.size(); ++i)
            means[i] += values[i] / values[0] / kPublishedScenes.size();
    }
    return means;
}

void check_means(const json& field, const Costs& means) {
    REQUIRE(field.size() == kPublishedBuilders);
    std::size_t i = 0;
    for (const tool::AilaBuilder& builder : tool::aila_builders()) {
        INFO(builder.id);
        CHECK(field[std::string(builder.id)].get<double>() == Approx(means[i++]).margin(0.000501));
    }
}

}  // namespace

TEST_CASE("the means that tables are compared with come from the paper's tables") {
    const json relative = published()["aila"]["relative_to_lbvh"];
    check_means(relative["sah"], mean_relative([](const PublishedScene& scene) { return scene.sah; }));
    check_means(relative["epo"], mean_relative([](const PublishedScene& scene) { return scene.epo; }));
    check_means(relative["lcv"], mean_relative([](const PublishedScene& scene) { return scene.lcv; }));
    check_means(relative["ns_per_ray scalar"],
                mean_relative([](const PublishedScene& scene) { return scene.scalar.ns_per_ray; }));
    check_means(relative["ns_per_ray SIMD"],
                mean_relative([](const PublishedScene& scene) { return scene.simd.ns_per_ray; }));
    // Section 5 states these.
    CHECK(relative["epo"]["bittner"].get<double>() == Approx(0.45).margin(0.005));
    CHECK(relative["epo"]["bbvh"].get<double>() == Approx(0.46).margin(0.005));
    CHECK(relative["epo"]["anneal"].get<double>() == Approx(0.81).margin(0.0051));
    CHECK(relative["epo"]["agglo"].get<double>() == Approx(1.07).margin(0.005));
}

TEST_CASE("a room and a scan of the paper's have these costs beside sweep trees") {
    const json parts = published()["aila"]["sah_over_bbvh"];
    CHECK(parts.size() == 2);
    for (const PublishedScene& scene : kPublishedScenes) {
        if (!parts.contains(scene.name)) continue;
        std::size_t i = 0;
        for (const tool::AilaBuilder& builder : tool::aila_builders()) {
            const double part = scene.sah[i++] / scene.sah[1];
            INFO(scene.name << ", " << builder.id);
            if (!parts[scene.name].contains(builder.id)) continue;
            CHECK(parts[scene.name][std::string(builder.id)].get<double>() == Approx(part).margin(0.000501));
        }
    }
}

TEST_CASE("Kensler's costs give the percentages of his table") {
    const json scenes = published()["kensler"]["scenes"];
    const std::vector<double> climbed{99.5, 99.7, 92.8, 93.4, 98.4, 90.8, 89.5, 91.4};
    const std::vector<double> annealed{99.5, 99.7, 88.2, 88.7, 95.5, 84.2, 84.5, 81.8};
    REQUIRE(scenes.size() == climbed.size());
    for (std::size_t i = 0; i < scenes.size(); ++i) {
        const double before = scenes[i]["sah"];
        INFO(scenes[i]["scene"]);
        CHECK(100.0 * scenes[i]["rotate"].get<double>() / before == Approx(climbed[i]).margin(0.06));
        CHECK(100.0 * scenes[i]["anneal"].get<double>() / before == Approx(annealed[i]).margin(0.06));
    }
}
