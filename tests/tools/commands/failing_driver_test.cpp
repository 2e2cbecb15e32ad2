#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/scratch_folder.hpp"
#include "tools/tool_process.hpp"

using namespace clbvh::test;
using Catch::Matchers::Contains;
using nlohmann::ordered_json;

namespace {

/// Puts the driver that fails beside those of the system, ahead of them in the folder's order, or alone.
std::string vendors(const ScratchFolder& folder, bool is_alone) {
    const std::filesystem::path system = "/etc/OpenCL/vendors";
    if (!is_alone && std::filesystem::is_directory(system)) {
        for (const auto& entry : std::filesystem::directory_iterator(system))
            std::filesystem::copy(entry.path(), folder.path(entry.path().filename()));
    }
    std::ofstream(folder.path("0_failing.icd")) << CLBVH_FAILING_DRIVER;
    return "OCL_ICD_VENDORS=" + std::filesystem::path(folder.path("0_failing.icd")).parent_path().string() + "/";
}

}  // namespace

TEST_CASE("a driver that fails hides no other, and clbvh devices names it") {
    const ordered_json expected = ordered_json::parse(run_tool({"devices", "--json", "-"}).out)["devices"];
    const ScratchFolder folder;
    const std::string environment = vendors(folder, false);
    for (const std::string error : {"-5", "-6", "-30", "-33", "-9999"}) {
        INFO("error " << error);
        const std::vector<std::string> failing{environment, "FAILING_DRIVER_DEVICES=" + error};
        const Outcome outcome = run_tool({"devices", "--json", "-"}, failing);
        REQUIRE(outcome.exit_code == 0);
        const ordered_json document = ordered_json::parse(outcome.out);
        CHECK(document["devices"] == expected);
        REQUIRE(document["failing_platforms"].size() == 1);
        CHECK(document["failing_platforms"][0]["platform"] == "A failing driver");
        CHECK_THAT(document["failing_platforms"][0]["reason"].get<std::string>(), Contains(error));
        CHECK_THAT(run_tool({"devices"}, failing).out, Contains("A failing driver is passed over: "));
    }
    const Outcome build = run_tool({"build", "gen:sphere:1000", "--builder", "lbvh"},
                                   {environment, "FAILING_DRIVER_DEVICES=-6", "FAILING_DRIVER_NAME=-30"});
    CHECK(build.exit_code == 0);
    CHECK(build.err.empty());
}

TEST_CASE("where the only driver fails, or HOME cannot be written, the error says so") {
    const ScratchFolder folder;
    const std::string environment = vendors(folder, true);
    const Outcome failing = run_tool({"devices"}, {environment, "FAILING_DRIVER_DEVICES=-6"});
    CHECK(failing.exit_code == 1);
    CHECK_THAT(failing.err, Contains("A failing driver fails: ") && Contains("-6") && Contains("install a driver"));
    const Outcome quiet = run_tool({"devices"}, {environment, "HOME=" + missing_path("home")});
    CHECK(quiet.exit_code == 1);
    CHECK_THAT(quiet.err, Contains("cannot be written") && !Contains("fails"));
}
