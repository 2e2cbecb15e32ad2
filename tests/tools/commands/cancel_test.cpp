#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "tools/scratch_folder.hpp"
#include "tools/tool_process.hpp"

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

TEST_CASE("SIGTERM ends a build as Ctrl-C does, with an exit code of its own") {
    const ScratchFolder folder;
    ToolProcess tool({"build", "gen:soup:500000", "-o", folder.path("tree.bvh"), "--json", folder.path("tree.json")});
    tool.interrupt(SIGTERM);
    const Outcome outcome = tool.wait();
    CHECK(outcome.exit_code == 143);
    CHECK(outcome.err == "clbvh: cancelled\n");
    CHECK(folder.file_count() == 0);
}

TEST_CASE("Ctrl-C ends the loading of a file") {
    const ScratchFolder folder;
    {
        std::ofstream file(folder.path("many.off"));
        file << "OFF\n3000000 0 0\n";
        for (int i = 0; i < 3000000; ++i)
            file << "0.25 0.5 0.75\n";
    }
    ToolProcess tool({"info", folder.path("many.off")});
    tool.interrupt();
    expect_cancelled(tool.wait());
}

TEST_CASE("Ctrl-C ends a benchmark without a trace") {
    const ScratchFolder folder;
    ToolProcess tool({"bench", "gen:soup:1000", "--runs", "1000000", "--json", folder.path("bench.json")});
    tool.interrupt();
    expect_cancelled(tool.wait());
    CHECK(folder.file_count() == 0);
}

TEST_CASE("Ctrl-C in a later scene of a benchmark keeps the earlier ones") {
    const ScratchFolder folder;
    const std::string text = folder.path("bench.txt");
    const std::string json = folder.path("bench.json");
    const int out = open(text.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
    REQUIRE(out >= 0);
    ToolProcess tool(
        {"bench", "gen:soup:10", "gen:soup:100000", "--builders", "median", "--runs", "10000", "--json", json}, {}, -1,
        out);
    close(out);
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (read_text(text).find("native sort") == std::string::npos && std::chrono::steady_clock::now() < deadline)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    tool.interrupt();
    CHECK(tool.wait().exit_code == 130);
    const auto document = nlohmann::json::parse(read_text(json));
    CHECK(document["incomplete"] == "interrupted");
    REQUIRE(document["results"].size() == 1);
    CHECK(document["results"][0]["scene"] == "gen:soup:10");
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
