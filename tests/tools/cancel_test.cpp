#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <thread>

#include "scratch_folder.hpp"
#include "tool_process.hpp"

using namespace clbvh::test;
using Catch::Matchers::Contains;

namespace {

/// The two ends of a terminal that a program drives.
struct Terminal {
    int program = posix_openpt(O_RDWR | O_NOCTTY);
    int user = -1;

    Terminal() {
        REQUIRE(program >= 0);
        REQUIRE(grantpt(program) == 0);
        REQUIRE(unlockpt(program) == 0);
        user = open(ptsname(program), O_RDWR | O_NOCTTY);
        REQUIRE(user >= 0);
    }
    Terminal(const Terminal&) = delete;
    Terminal& operator=(const Terminal&) = delete;
    ~Terminal() {
        close(program);
        if (user >= 0) close(user);
    }

    /// Everything shown, read until no process has the terminal open.
    std::string read_to_end() {
        close(user);
        user = -1;
        std::string text;
        std::array<char, 4096> buffer;
        for (ssize_t size = 1; size > 0;) {
            size = read(program, buffer.data(), buffer.size());
            if (size > 0) text.append(buffer.data(), static_cast<std::size_t>(size));
        }
        return text;
    }
};

void expect_cancelled(const Outcome& outcome) {
    CHECK(outcome.exit_code == 130);
    CHECK(outcome.out.empty());
    CHECK(outcome.err == "clbvh: cancelled\n");
}

}  // namespace

TEST_CASE("Ctrl-C ends a build without a trace") {
    const ScratchFolder folder;
    ToolProcess tool({"build", "gen:soup:500000", "-o", folder.path("tree.bvh"), "--json", "-"});
    tool.interrupt();
    expect_cancelled(tool.wait());
    CHECK(folder.file_count() == 0);
}

TEST_CASE("Ctrl-C ends a benchmark without a trace") {
    const ScratchFolder folder;
    ToolProcess tool({"bench", "gen:soup:1000", "--runs", "1000000", "--json", folder.path("bench.json")});
    tool.interrupt();
    expect_cancelled(tool.wait());
    CHECK(folder.file_count() == 0);
}

TEST_CASE("a terminal shows progress, and keeps nothing of it") {
    Terminal terminal;
    ToolProcess tool({"build", "gen:soup:200000", "--json", "-"}, {}, terminal.user);
    const std::string shown = terminal.read_to_end();
    const Outcome outcome = tool.wait();
    CHECK(outcome.exit_code == 0);
    CHECK_THAT(shown, Contains("[") && Contains("%") && Catch::Matchers::EndsWith("\r\x1b[K"));
    CHECK(outcome.out.starts_with('{'));
}
