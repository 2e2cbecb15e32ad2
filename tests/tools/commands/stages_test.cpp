#include <catch2/catch.hpp>
#include <clbvh/device/context.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "measure/build_result.hpp"
#include "measure/copy_contestant.hpp"
#include "report/stage_report.hpp"
#include "tools/tool_process.hpp"

using namespace clbvh;
using namespace clbvh::test;
using namespace clbvh::tool;
using Catch::Matchers::Contains;

namespace {

/// Two stages on the device and one on the host: 10 ms, of which 3 are neither.
BuildStats run_of_ten() {
    BuildStats run;
    run.build_ms = 10.0;
    run.launches = 3;
    run.stages = {{"bounds", 1.0, 1.5, 1, 8'000'000}, {"sort", 4.0, 5.0, 2, 0}, {"collapse", 0.0, 2.0, 0, 0}};
    return run;
}

BuildResult result_of_ten() {
    BuildResult result;
    result.builder = "some-builder";
    const BuildStats run = run_of_ten();
    summarize_runs(result, std::span(&run, 1));
    return result;
}

}  // namespace

TEST_CASE("launches cost what is left of a build beside kernels and stages on the host") {
    CHECK(result_of_ten().launch_overhead_ms.median == Approx(3.0));
    std::vector<BuildStats> runs(3, run_of_ten());
    runs[1].build_ms = 12.0;
    runs[2].build_ms = 6.0;  // A clock that went backwards costs nothing.
    BuildResult result;
    summarize_runs(result, runs);
    CHECK(result.launch_overhead_ms.median == Approx(3.0));
    CHECK(result.launch_overhead_ms.max == Approx(5.0));
    CHECK(result.launch_overhead_ms.min == 0.0);
}

TEST_CASE("a stage's speed is its bytes by its device time") {
    const BuildResult result = result_of_ten();
    CHECK(gb_per_s(result.stages[0]) == Approx(8.0));
    CHECK(std::isnan(gb_per_s(result.stages[1])));
    CHECK(std::isnan(gb_per_s(result.stages[2])));
    CHECK(ran_on_host(result.stages[2]));
    CHECK_FALSE(ran_on_host(result.stages[0]));
}

TEST_CASE("the table of stages sums to the build, and compares with the copy") {
    BuildResult result = result_of_ten();
    result.copy_gb_per_s = Sample{32.0, 30.0, 33.0};
    BuildResult host = result;
    host.kind = BuilderKind::host;
    host.builder = "host-builder";
    const std::vector<BuildResult> results{host, result};
    CHECK(stage_report(results) ==
          "builder                 stage     ms  share %  MB moved  GB/s  % of copy\n"
          "some-builder           bounds  1.000     10.0       8.0   8.0         25\n"
          "some-builder             sort  4.000     40.0         -     -          -\n"
          "some-builder  collapse (host)  2.000     20.0         -     -          -\n"
          "some-builder       3 launches  3.000     30.0         -     -          -\n"
          "copy on the device  32.0 GB/s read and written; launches: the build less all other rows\n");
    CHECK_THAT(stage_report(std::span(results).first(1)), Contains("none of these builders ran on a device"));
}

TEST_CASE("the copy copies, and its speed is measured") {
    CopyContestant copy(Context::open());
    copy.run(false);
    CHECK(copy.is_right());
    CHECK(copy.gb_per_s().max == 0.0);
    copy.run(true);
    copy.run(true);
    CHECK(copy.gb_per_s().min > 0.0);
    // Faster than any memory is: a time that was not the copy's.
    CHECK(copy.gb_per_s().max < 1e5);
}

TEST_CASE("bench shows stages where they are asked for") {
    const std::vector<std::string> words{"bench", "gen:soup:1000", "--builders", "lbvh,median", "--runs", "1"};
    std::vector<std::string> with_stages = words;
    with_stages.emplace_back("--stages");
    CHECK_THAT(run_tool(words).out, !Contains("% of copy"));
    const Outcome outcome = run_tool(with_stages);
    REQUIRE(outcome.exit_code == 0);
    CHECK_THAT(outcome.out, Contains("% of copy") && Contains("copy on the device") && Contains(" launches "));
    for (const char* stage : {"bounds", "morton", "sort", "cluster", "root"})
        CHECK_THAT(outcome.out, Contains(std::string(" ") + stage + " "));
}
