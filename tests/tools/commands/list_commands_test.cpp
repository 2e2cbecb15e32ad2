#include <algorithm>
#include <catch2/catch.hpp>
#include <clbvh/catalog.hpp>
#include <clbvh/device/device.hpp>
#include <clbvh/io/scene.hpp>
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

/// The document that `command --json -` prints, alone, on standard output.
ordered_json json_of(const std::string& command) {
    const Outcome outcome = run_tool({command, "--json", "-"});
    REQUIRE(outcome.exit_code == 0);
    CHECK(outcome.err.empty());
    return ordered_json::parse(outcome.out);
}

}  // namespace

TEST_CASE("builders lists the table of builders") {
    const ordered_json list = json_of("builders")["builders"];
    const Outcome table = run_tool({"builders"});
    REQUIRE(list.size() == builders().size());
    for (std::size_t i = 0; i < list.size(); ++i) {
        const BuilderInfo& builder = builders()[i];
        CHECK(list[i]["id"] == builder.id);
        CHECK(list[i]["title"] == builder.title);
        CHECK(list[i]["paper"] == builder.paper);
        CHECK(list[i]["kind"] == (builder.kind == BuilderKind::device ? "device" : "host"));
        for (const OptionInfo& option : options()) {
            const bool is_listed = std::ranges::count(list[i]["options"], option.name) > 0;
            CHECK(is_listed == (option.readers != "all" && reads_option(builder.id, option.name)));
        }
        CHECK(list[i]["available"] == true);
        CHECK_THAT(table.out, Contains(std::string(builder.id)) && Contains(std::string(builder.title)));
    }
}

TEST_CASE("builders lists the table of optimizers too") {
    const ordered_json list = json_of("builders")["optimizers"];
    const Outcome table = run_tool({"builders"});
    REQUIRE(list.size() == optimizers().size());
    for (std::size_t i = 0; i < list.size(); ++i) {
        CHECK(list[i]["id"] == optimizers()[i].id);
        CHECK(list[i]["title"] == optimizers()[i].title);
        CHECK(list[i]["paper"] == optimizers()[i].paper);
        CHECK(list[i]["splits_first"] == optimizers()[i].splits_first);
        CHECK(list[i]["on_device"] == optimizers()[i].on_device);
        CHECK_THAT(table.out,
                   Contains(std::string(optimizers()[i].id)) && Contains(std::string(optimizers()[i].title)));
    }
}

TEST_CASE("builders lists the presets, and which of them can run") {
    const ordered_json list = json_of("builders")["presets"];
    const Outcome table = run_tool({"builders"});
    REQUIRE(list.size() == presets().size());
    const ordered_json without_device =
        ordered_json::parse(run_tool({"builders", "--json", "-"}, {no_drivers()}).out)["presets"];
    for (std::size_t i = 0; i < list.size(); ++i) {
        const PresetInfo& preset = presets()[i];
        CHECK(list[i]["id"] == preset.id);
        CHECK(list[i]["builder"] == preset.builder);
        CHECK(list[i]["optimizers"] == preset.optimizers);
        CHECK(list[i]["optimize_passes"] == preset.optimize_passes);
        CHECK(list[i]["max_leaf_size"] == preset.max_leaf_size);
        CHECK(list[i]["leaf_size"] == preset.leaf_size);
        CHECK(list[i]["code_bits"] == preset.code_bits);
        CHECK(list[i]["split_overlap"] == preset.split_overlap);
        CHECK(list[i]["opening"] == to_string(preset.opening));
        CHECK(list[i]["available"] == true);
        CHECK(without_device[i]["available"] == (find_builder(preset.id).kind == BuilderKind::host));
        CHECK_THAT(table.out, Contains(std::string(preset.id)) && Contains(std::string(preset.title)));
    }
}

TEST_CASE("without a device, builders says which of them cannot run, and why") {
    const std::vector<std::string> no_driver{no_drivers()};
    const Outcome outcome = run_tool({"builders", "--json", "-"}, no_driver);
    REQUIRE(outcome.exit_code == 0);
    const ordered_json list = ordered_json::parse(outcome.out)["builders"];
    REQUIRE(list.size() == builders().size());
    for (std::size_t i = 0; i < list.size(); ++i) {
        const bool on_host = builders()[i].kind == BuilderKind::host;
        CHECK(list[i]["available"] == on_host);
        CHECK(list[i].contains("reason") == !on_host);
        if (!on_host) CHECK_THAT(list[i]["reason"].get<std::string>(), Contains("pocl-opencl-icd"));
    }
    const Outcome table = run_tool({"builders"}, no_driver);
    CHECK(table.exit_code == 0);
    CHECK_THAT(table.out, Contains("not available: ") && Contains("pocl-opencl-icd"));
    CHECK_THAT(run_tool({"builders"}).out, !Contains("not available: "));
}

TEST_CASE("options lists the table of options") {
    const ordered_json list = json_of("options")["options"];
    const Outcome table = run_tool({"options"});
    REQUIRE(list.size() == options().size());
    for (std::size_t i = 0; i < list.size(); ++i) {
        const OptionInfo& option = options()[i];
        CHECK(list[i]["name"] == option.name);
        CHECK(list[i]["flag"] == option.flag);
        CHECK(list[i]["values"] == option.values);
        CHECK(list[i]["default"] == option.default_value);
        CHECK(list[i]["readers"] == option.readers);
        CHECK(list[i]["help"] == option.help);
        CHECK_THAT(table.out, Contains(std::string(option.name)) && Contains(std::string(option.flag)));
    }
}

TEST_CASE("the page of options ends with the table as it is") {
    const std::string page = read_text(CLBVH_DOCS "/options.md");
    CHECK_THAT(page, Catch::Matchers::EndsWith(run_tool({"options", "--markdown"}).out));
}

TEST_CASE("scenes lists the generators") {
    const ordered_json document = json_of("scenes");
    const Outcome table = run_tool({"scenes"});
    CHECK(document["default_triangles"] == kDefaultSceneTriangles);
    const ordered_json& list = document["scenes"];
    REQUIRE(list.size() == scene_generators().size());
    for (std::size_t i = 0; i < list.size(); ++i) {
        const std::string name(scene_generators()[i].name);
        CHECK(list[i]["name"] == name);
        CHECK(list[i]["description"] == scene_generators()[i].description);
        CHECK_THAT(table.out, Contains("gen:" + name));
    }
}

TEST_CASE("devices lists what the library finds, and marks the default") {
    const ordered_json list = json_of("devices")["devices"];
    const Outcome table = run_tool({"devices"});
    REQUIRE(list.size() == list_devices().size());
    for (const ordered_json& device : list) {
        check_device(device);
        CHECK(device["default"] == (device["index"] == pick_device().index));
        CHECK_THAT(table.out, Contains(device["name"].get<std::string>()));
    }
}

TEST_CASE("devices tells on request how each does in the self-test") {
    CHECK_FALSE(json_of("devices")["devices"][0].contains("self_test_passed"));
    const Outcome outcome = run_tool({"devices", "--self-test", "--json", "-"});
    const ordered_json list = ordered_json::parse(outcome.out)["devices"];
    bool all_passed = true;
    for (const ordered_json& device : list)
        all_passed = all_passed && device["self_test_passed"] == true;
    CHECK(outcome.exit_code == (all_passed ? 0 : 1));
    if (all_passed) CHECK_THAT(run_tool({"devices", "--self-test"}).out, Contains("device 0: self-test passed"));
}

TEST_CASE("devices shows what there is though CLBVH_DEVICE names what there is not") {
    const Outcome outcome = run_tool({"devices", "--json", "-"}, {"CLBVH_DEVICE=no such device"});
    REQUIRE(outcome.exit_code == 0);
    const ordered_json list = ordered_json::parse(outcome.out)["devices"];
    REQUIRE(list.size() == list_devices().size());
    for (const ordered_json& device : list)
        CHECK(device["default"] == false);
}

TEST_CASE("a machine without OpenCL devices is told what to install") {
    const Outcome outcome = run_tool({"devices", "--json", "-"}, {no_drivers()});
    CHECK(outcome.exit_code == 1);
    CHECK(outcome.out.empty());
    CHECK_THAT(outcome.err, Contains("clbvh: error: ") && Contains("pocl-opencl-icd"));
}

TEST_CASE("JSON in a file is the same as on standard output, beside the text for people") {
    const ScratchFolder folder;
    for (const std::string command : {"devices", "builders", "options", "scenes"}) {
        const std::string path = folder.path(command + ".json");
        const Outcome outcome = run_tool({command, "--json", path});
        CHECK(outcome.exit_code == 0);
        CHECK(outcome.out == run_tool({command}).out);
        CHECK(read_text(path) == run_tool({command, "--json", "-"}).out);
    }
    CHECK(folder.file_count() == 4);
}

TEST_CASE("JSON that cannot be written is an error that names the file") {
    const ScratchFolder folder;
    const Outcome missing = run_tool({"builders", "--json", folder.path("none/x.json")});
    CHECK(missing.exit_code == 1);
    CHECK(missing.out.empty());
    CHECK_THAT(missing.err, Contains("none/x.json") && Contains("No such file or directory"));
    const Outcome directory = run_tool({"builders", "--json", folder.path("")});
    CHECK(directory.exit_code == 1);
    CHECK_THAT(directory.err, Contains("not a regular file"));
    const Outcome full = run_tool({"builders", "--json", "/dev/full"});
    CHECK(full.exit_code == 1);
    CHECK_THAT(full.err, Contains("/dev/full"));
}
