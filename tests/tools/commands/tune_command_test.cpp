#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/scratch_folder.hpp"
#include "tools/tool_process.hpp"

using namespace clbvh::test;
using Catch::Matchers::Contains;
using nlohmann::ordered_json;

namespace {

const std::vector<std::string> kSmall{"tune", "gen:soup:500", "gen:city:700", "--runs", "1"};

std::vector<std::string> with(std::vector<std::string> words, const std::vector<std::string>& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

ordered_json json_of(const std::vector<std::string>& words, const std::vector<std::string>& environment) {
    const Outcome outcome = run_tool(with(words, {"--json", "-"}), environment);
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    return ordered_json::parse(outcome.out);
}

/// Every knob has its own choice first, in all scenes, and one chosen value that the profile records.
void check_tried(const ordered_json& tried, const ordered_json& profile) {
    REQUIRE(tried.size() >= 2);
    for (const ordered_json& knob : tried) {
        INFO(knob.dump(2));
        const std::string option = knob["option"];
        const ordered_json& trials = knob["trials"];
        REQUIRE(trials.size() >= 3);
        CHECK(trials[0]["value"] == "auto");
        CHECK(trials[0]["relative"] == 1.0);
        std::vector<std::string> chosen;
        for (const ordered_json& trial : trials) {
            REQUIRE(trial["scenes"].size() == 2);
            CHECK(trial["scenes"][0]["scene"] == "gen:soup:500");
            CHECK(trial["scenes"][1]["build_ms"]["median"].get<double>() > 0.0);
            if (trial["chosen"] == true) chosen.push_back(trial["value"]);
        }
        REQUIRE(chosen.size() == 1);
        CHECK(profile.contains(option) == (chosen[0] != "auto"));
        if (!profile.contains(option)) continue;
        CHECK((profile[option].is_string() ? profile[option].get<std::string>() : profile[option].dump()) == chosen[0]);
    }
}

}  // namespace

TEST_CASE("tune writes the device's profile, which devices and build then show") {
    const ScratchFolder folder;
    const std::vector<std::string> environment{"XDG_CONFIG_HOME=" + folder.path("config"), "CLBVH_PROFILE="};
    CHECK(json_of({"build", "gen:soup:100"}, environment)["profile"].is_null());
    const ordered_json before = json_of({"devices"}, environment)["devices"][0]["profile"];
    CHECK(before["used"] == false);

    const ordered_json document = json_of(kSmall, environment);
    const std::string file = document["file"];
    CHECK_THAT(file, Contains(folder.path("config")));
    CHECK(before["file"] == file);
    for (const auto& [name, value] : document["profile"].items()) {
        const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
        CHECK_THAT(read_text(file), Contains("\n" + name + " = " + text + "\n"));
    }
    CHECK(document["profile"]["device"] == document["device"]["name"]);
    CHECK(document["runs"] == 1);
    CHECK(document["profile"]["hand_over"] == "within");
    check_tried(document["tried"], document["profile"]);

    CHECK(json_of({"build", "gen:soup:100"}, environment)["profile"] == file);
    CHECK(json_of({"build", "gen:soup:100", "--builder", "median"}, environment)["profile"].is_null());
    CHECK(json_of({"devices"}, environment)["devices"][0]["profile"] == ordered_json{{"file", file}, {"used", true}});
    CHECK_THAT(run_tool({"devices"}, environment).out, Contains("profile " + file));
}

TEST_CASE("tune -o writes another file, which CLBVH_PROFILE names") {
    const ScratchFolder folder;
    const std::string file = folder.path("mine.txt");
    const Outcome outcome = run_tool(with(kSmall, {"-o", file}), {"CLBVH_PROFILE=off"});
    REQUIRE(outcome.exit_code == 0);
    CHECK_THAT(outcome.out, Contains("single_group_threshold") && Contains("gen:city:700 ms") && Contains("chosen") &&
                                Contains("CLBVH_PROFILE=" + file));
    CHECK(json_of({"build", "gen:soup:100"}, {"CLBVH_PROFILE=" + file})["profile"] == file);
    CHECK(json_of({"build", "gen:soup:100"}, {"CLBVH_PROFILE=off"})["profile"].is_null());
}

TEST_CASE("a profile that CLBVH_PROFILE names in vain stops builds, and devices says why") {
    const std::vector<std::string> environment{"CLBVH_PROFILE=" + missing_path("profile")};
    const Outcome build = run_tool({"build", "gen:soup:100"}, environment);
    CHECK(build.exit_code == 1);
    CHECK_THAT(build.err, Contains("CLBVH_PROFILE") && Contains(missing_path("profile")));
    const Outcome devices = run_tool({"devices"}, environment);
    CHECK(devices.exit_code == 0);
    CHECK_THAT(devices.out, Contains(missing_path("profile") + " is not used"));
}

TEST_CASE("tune refuses what cannot be before it measures") {
    CHECK(run_tool({"tune", "--runs", "0"}).exit_code == 2);
    const Outcome scene = run_tool({"tune", "gen:nothing"});
    CHECK(scene.exit_code == 1);
    CHECK_THAT(scene.err, Contains("gen:nothing"));
    const Outcome file = run_tool(with(kSmall, {"-o", missing_path("folder/profile.txt")}));
    CHECK(file.exit_code == 1);
    CHECK_THAT(file.err, Contains(missing_path("folder")));
    const Outcome homeless = run_tool(kSmall, {"HOME=", "XDG_CONFIG_HOME="});
    CHECK(homeless.exit_code == 1);
    CHECK_THAT(homeless.err, Contains("use -o"));
}
