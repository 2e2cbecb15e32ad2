// The launcher's books: launches, times, progress, and how a build ends early.
#include "device/opencl/launcher.hpp"

#include <catch2/catch.hpp>

#include "device/build/stage_bench.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;
using device::Kernel;
using device::Launcher;
using device::Session;

namespace {

constexpr std::uint32_t kCount = 1000;

Session& session() {
    return shared_context().session();
}

Kernel& number_leaves(Session& on) {
    return on.kernel("leaves.cl", "number_leaves", 1, "");
}

cl::Buffer numbers(Session& on) {
    return {on.context(), CL_MEM_READ_WRITE, kCount * sizeof(std::uint32_t)};
}

/// kCount in device memory.
cl::Buffer leaf_count(Session& on) {
    std::uint32_t count = kCount;
    return {on.context(), CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, sizeof(count), &count};
}

/// Launches a kernel that writes 0, 1, 2 ... with this many groups.
void launch_numbering(Launcher& launcher, const cl::Buffer& out, std::uint32_t groups) {
    launcher.launch(number_leaves(launcher.session()), groups, leaf_count(launcher.session()),
                    (kCount + groups - 1) / groups, out);
}

/// A progress callback that records its calls and returns false after some.
struct Listener {
    std::vector<std::pair<std::string, double>> heard;
    std::size_t allowed = 1000;

    ProgressCallback callback() {
        return [this](const Progress& progress) {
            heard.emplace_back(progress.stage, progress.fraction);
            return heard.size() <= allowed;
        };
    }
};

}  // namespace

TEST_CASE("launcher: launches run all their groups, and are counted by stage") {
    const ProgressCallback none;
    Launcher launcher(session(), none);
    const cl::Buffer out = numbers(session());
    launcher.begin_stage("first", 0.0);
    for (const std::uint32_t groups : {1u, 3u, 1000u})
        launch_numbering(launcher, out, groups);
    launcher.begin_stage("second", 0.5);
    launcher.begin_stage("third", 0.6);
    launch_numbering(launcher, out, 7);
    std::vector<std::uint32_t> expected(kCount);
    for (std::uint32_t i = 0; i < kCount; ++i)
        expected[i] = i;
    CHECK(read<std::uint32_t>(out, kCount) == expected);

    const BuildStats stats = launcher.finish();
    REQUIRE(stats.stages.size() == 3);
    CHECK(stats.launches == 4);
    CHECK(stats.stages[0].name == "first");
    CHECK(stats.stages[0].launches == 3);
    CHECK(stats.stages[1].launches == 0);
    CHECK(stats.stages[2].launches == 1);
    CHECK(stats.stages[0].device_ms > 0.0);
    CHECK(stats.stages[1].device_ms == 0.0);
    CHECK(stats.stages[2].device_ms > 0.0);
    const double host_ms = stats.stages[0].host_ms + stats.stages[1].host_ms + stats.stages[2].host_ms;
    CHECK(host_ms > 0.0);
    CHECK(host_ms <= stats.build_ms);
}

TEST_CASE("launcher: without a profiling queue device times are zero and the rest is counted") {
    const cl::CommandQueue queue(session().context(), session().context().getInfo<CL_CONTEXT_DEVICES>().front());
    Session plain(queue());
    const ProgressCallback none;
    Launcher launcher(plain, none);
    const cl::Buffer out = numbers(plain);
    launcher.begin_stage("only", 0.0);
    launch_numbering(launcher, out, 4);
    const BuildStats stats = launcher.finish();
    CHECK(stats.launches == 1);
    CHECK(stats.stages[0].device_ms == 0.0);
    CHECK(stats.stages[0].host_ms > 0.0);
}

TEST_CASE("launcher: a number is read when all before it is done") {
    const ProgressCallback none;
    Launcher launcher(session(), none);
    launcher.begin_stage("only", 0.0);
    const cl::Buffer out = numbers(session());
    launch_numbering(launcher, out, 1);
    const cl::Buffer last = device::view_of({out}, 0, 4);
    CHECK(launcher.read_uint(last) == 0);
    write(out, std::vector<std::uint32_t>{77});
    CHECK(launcher.read_uint(out) == 77);
}

TEST_CASE("launcher: iterations are kept in their order") {
    const ProgressCallback none;
    Launcher launcher(session(), none);
    launcher.begin_stage("only", 0.0);
    for (const std::uint32_t clusters : {900u, 500u, 2u})
        launcher.count_iteration(clusters);
    const BuildStats stats = launcher.finish();
    CHECK(stats.iterations == 3);
    CHECK(stats.clusters_per_iteration == std::vector<std::uint32_t>{900, 500, 2});
}

TEST_CASE("launcher: progress names the stage, never falls and never passes 1") {
    Listener listener;
    const ProgressCallback callback = listener.callback();
    Launcher launcher(session(), callback);
    launcher.begin_stage("first", 0.0);
    launcher.report(0.4);
    launcher.report(0.2);
    launcher.begin_stage("second", 0.3);
    launcher.report(7.0);
    (void)launcher.finish();
    const std::vector<std::pair<std::string, double>> expected{
        {"first", 0.0}, {"first", 0.4}, {"first", 0.4}, {"second", 0.4}, {"second", 1.0}};
    CHECK(listener.heard == expected);
}

TEST_CASE("launcher: a callback that says no cancels, and everything enqueued is done by then") {
    for (const std::size_t allowed : {0u, 1u, 2u}) {
        Listener listener;
        listener.allowed = allowed;
        const ProgressCallback callback = listener.callback();
        Launcher launcher(session(), callback);
        std::string stage;
        cl::Event event;
        expect_error(ErrorCode::cancelled, {"cancelled in stage " + std::to_string(allowed)}, [&] {
            for (std::size_t i = 0; i < 3; ++i) {
                launcher.begin_stage(std::to_string(i), 0.1);
                launch_numbering(launcher, numbers(session()), 100);
                session().queue().enqueueMarkerWithWaitList(nullptr, &event);
            }
        });
        CHECK(listener.heard.size() == allowed + 1);
        if (allowed > 0) CHECK(event.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() == CL_COMPLETE);
    }
}

TEST_CASE("launcher: arguments that do not fit the kernel are an error that names it") {
    const ProgressCallback none;
    Launcher launcher(session(), none);
    launcher.begin_stage("only", 0.0);
    const cl::Buffer out = numbers(session());
    expect_error(ErrorCode::device_failure, {"kernel number_leaves"},
                 [&] { launcher.launch(number_leaves(session()), 1, out, kCount, out, out); });
    expect_error(ErrorCode::device_failure, {"kernel number_leaves"},
                 [&] { launcher.launch(number_leaves(session()), 1, out, std::uint64_t{kCount}, out); });
    CHECK(launcher.finish().launches == 0);
}
