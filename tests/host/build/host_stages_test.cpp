// Stages of a host build: times, progress that never falls, cancellation from the callback to every task.
#include "host/build/host_stages.hpp"

#include <catch2/catch.hpp>
#include <thread>
#include <vector>

#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;
using host::HostStages;

TEST_CASE("host stages are booked in order with their times") {
    const ProgressCallback none;
    HostStages stages(none);
    stages.begin("first", 0.0, 0.5);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    stages.begin("second", 0.5, 1.0);
    const BuildStats stats = stages.finish();
    REQUIRE(stats.stages.size() == 2);
    CHECK(stats.stages[0].name == "first");
    CHECK(stats.stages[0].host_ms >= 5.0);
    CHECK(stats.stages[1].name == "second");
    CHECK(stats.build_ms >= stats.stages[0].host_ms + stats.stages[1].host_ms);
}

TEST_CASE("host stages report progress that never falls and stays in its stage") {
    std::vector<std::pair<std::string, double>> reports;
    const ProgressCallback callback = [&](const Progress& progress) {
        reports.emplace_back(progress.stage, progress.fraction);
        return true;
    };
    HostStages stages(callback);
    stages.begin("a", 0.1, 0.4, 3);
    for (int i = 0; i < 5; ++i) {  // more work than was announced
        std::this_thread::sleep_for(std::chrono::milliseconds(25));
        stages.advance(1);
    }
    stages.begin("b", 0.2, 1.0);  // begins below what was reported
    REQUIRE(reports.size() == 7);
    CHECK(reports[0] == std::pair<std::string, double>("a", 0.1));
    CHECK(reports[1].second == Approx(0.2));
    CHECK(reports[2].second == Approx(0.3));
    for (std::size_t i = 3; i < 6; ++i)
        CHECK(reports[i].second == Approx(0.4));
    CHECK(reports[6].first == "b");
    CHECK(reports[6].second == Approx(0.4));
}

TEST_CASE("host stages call back on their own thread only") {
    std::vector<std::thread::id> callers;
    const ProgressCallback callback = [&](const Progress&) {
        callers.push_back(std::this_thread::get_id());
        return true;
    };
    HostStages stages(callback);
    stages.begin("a", 0.0, 1.0, 2);
    std::thread([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(30));
        stages.advance(1);
    }).join();
    stages.advance(1);
    CHECK(callers == std::vector(2, std::this_thread::get_id()));
}

TEST_CASE("a callback that says no stops the build and all its tasks") {
    bool go_on = true;
    const ProgressCallback callback = [&](const Progress&) { return go_on; };
    HostStages stages(callback);
    stages.begin("a", 0.0, 1.0, 10);
    go_on = false;
    std::thread([&] { CHECK_NOTHROW(stages.advance(1)); }).join();  // the answer is not known yet
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    expect_error(ErrorCode::cancelled, {"cancelled"}, [&] { stages.advance(1); });
    std::thread([&] { expect_error(ErrorCode::cancelled, {"cancelled"}, [&] { stages.advance(1); }); }).join();
}

TEST_CASE("a callback that says no at once stops the first stage") {
    const ProgressCallback callback = [](const Progress&) { return false; };
    HostStages stages(callback);
    expect_error(ErrorCode::cancelled, {"cancelled"}, [&] { stages.begin("a", 0.0, 1.0); });
}
