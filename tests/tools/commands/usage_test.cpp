#include <fcntl.h>
#include <unistd.h>

#include <clbvh/version.h>
#include <catch2/catch.hpp>
#include <clbvh/options.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tools/scratch_folder.hpp"
#include "tools/tool_process.hpp"

using namespace clbvh;
using namespace clbvh::test;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

using Words = std::vector<std::string>;

void expect_usage_error(const Words& arguments, const std::string& part) {
    const Outcome outcome = run_tool(arguments);
    INFO(outcome.err);
    CHECK(outcome.exit_code == 2);
    CHECK(outcome.out.empty());
    CHECK_THAT(outcome.err, StartsWith("clbvh: error: ") && Contains(part));
}

}  // namespace

TEST_CASE("help names every command, and of each command every option") {
    const Outcome outcome = run_tool({"--help"});
    CHECK(outcome.exit_code == 0);
    CHECK(outcome.err.empty());
    for (const char* command :
         {"devices", "builders", "scenes", "info", "build", "bench", "tune", "trace", "metrics", "table", "dump"}) {
        CHECK_THAT(outcome.out, Contains(command));
        const Outcome help = run_tool({command, "--help"});
        CHECK(help.exit_code == 0);
        CHECK(help.err.empty());
        CHECK_THAT(help.out, Contains("--json FILE"));
    }
    CHECK_THAT(run_tool({"render", "--help"}).out, Contains("-o,--output FILE") && Contains("--mode NAME"));
    Words shared{"--device"};
    for (const OptionInfo& option : options())
        shared.emplace_back(option.flag);
    for (const char* command : {"build", "bench"}) {
        const Outcome help = run_tool({command, "--help"});
        for (const std::string& option : shared)
            CHECK_THAT(help.out, Contains(option));
    }
    CHECK_THAT(run_tool({"build", "--help"}).out, Contains("--builder") && Contains("-o") && Contains("--validate"));
    CHECK_THAT(run_tool({"bench", "--help"}).out, Contains("--builders") && Contains("--runs") && Contains("--peers") &&
                                                      Contains("--stages") && Contains("--sweep NAME") &&
                                                      Contains("--sweep-to"));
}

TEST_CASE("exit codes are right where nobody can read an error") {
    const int full = open("/dev/full", O_WRONLY);
    REQUIRE(full >= 0);
    CHECK(ToolProcess({"build", missing_path("nosuch.obj")}, {}, full).wait().exit_code == 1);
    CHECK(ToolProcess({"build"}, {}, full).wait().exit_code == 2);
    CHECK(ToolProcess({"scenes"}, {}, full, full).wait().exit_code == 1);
    close(full);
}

TEST_CASE("the version is the project's") {
    const Outcome outcome = run_tool({"--version"});
    CHECK(outcome.exit_code == 0);
    CHECK(outcome.out == "clbvh " CLBVH_VERSION_STRING "\n");
}

TEST_CASE("a wrong command line is a usage error") {
    expect_usage_error({}, "a command is missing");
    expect_usage_error({"paint"}, "paint");
    expect_usage_error({"build"}, "scene");
    expect_usage_error({"bench"}, "scene");
    expect_usage_error({"devices", "extra"}, "extra");
    expect_usage_error({"build", "gen:soup:10", "--colour", "red"}, "--colour");
    expect_usage_error({"build", "gen:soup:10", "--shape", "round"}, "--shape");
    expect_usage_error({"build", "gen:soup:10", "--morton", "zyx"}, "--morton");
    expect_usage_error({"build", "gen:soup:10", "--encoding", "bits16"}, "--encoding");
    expect_usage_error({"build", "gen:soup:10", "--search", "far"}, "--search");
    expect_usage_error({"build", "gen:soup:10", "--radius", "wide"}, "--radius");
    expect_usage_error({"build", "gen:soup:10", "--radius", "-1"}, "--radius");
    expect_usage_error({"build", "gen:soup:10", "--bins", "many"}, "--bins");
    expect_usage_error({"bench", "--presplit", "gen:soup:10", "gen:soup:20"}, "--presplit");
    for (const char* runs : {"0", "-1", "some"})
        expect_usage_error({"bench", "gen:soup:10", "--runs", runs}, "--runs: must be at least 1\n");
    for (const char* option : {"--max-leaf", "--threads", "--inner-cost"})
        expect_usage_error({"build", "gen:soup:10", option, ""}, std::string(option) + ": needs a number");
    for (const char* file : {"-", ""})
        expect_usage_error({"build", "gen:soup:10", "-o", file}, "-o needs a file");
    expect_usage_error({"bench", "gen:soup:10", "--json"}, "--json");
}

TEST_CASE("help tells ranges, and what options mean to whom") {
    // Where CLI11 breaks a line is no matter here.
    const auto words_of_help = [](const std::string& command) {
        std::istringstream help(run_tool({command, "--help"}).out);
        std::string words;
        for (std::string word; help >> word;)
            words += word + ' ';
        return words;
    };
    for (const char* command : {"build", "bench"}) {
        CHECK_THAT(
            words_of_help(command),
            Contains("Largest leaf: the builder's own where it makes leaves itself (binned-sah, sweep-sah, sbvh, "
                     "aac, median); then leaves are merged") &&
                Contains("as the builder leaves them (0 to 64)") && Contains("0: all (0 to 1024)") &&
                Contains("(2 to 64; binned-sah, sbvh)") && Contains("(finite and above 0)") &&
                Contains("finishes the tree (2 to 1048576, or 0 to have it chosen; plocpp)") &&
                Contains("an inner node, for building; reported SAH is always at 1.2 and 1.0") &&
                Contains("a primitive, for building; reported SAH is always at 1.2 and 1.0"));
    }
    CHECK_THAT(words_of_help("build"), Contains("Builds twice and reports the second time"));
    CHECK_THAT(words_of_help("bench"), Contains("they take --max-leaf, --budget, the costs and --threads, no other"));
}

TEST_CASE("an option that no chosen builder reads is noted, and changes nothing") {
    const Outcome unread =
        run_tool({"build", "gen:soup:100", "--builder", "median", "--radius", "8", "--threads", "1"});
    CHECK(unread.exit_code == 0);
    CHECK_THAT(unread.err, StartsWith("clbvh: note: --radius changes nothing here") && !Contains("--threads"));
    for (const Words& words :
         {Words{"build", "gen:soup:100", "--builder", "sbvh", "--bins", "8"},
          Words{"bench", "gen:soup:100", "--runs", "1", "--builders", "median,plocpp", "--radius", "8"}}) {
        const Outcome read = run_tool(words);
        CHECK(read.exit_code == 0);
        CHECK_THAT(read.err, !Contains("note"));
    }
}

TEST_CASE("standard output that cannot be written is an error") {
    const int full = open("/dev/full", O_WRONLY | O_CLOEXEC);
    REQUIRE(full >= 0);
    for (const Words& words : {Words{"builders"}, Words{"builders", "--json", "-"}, Words{"scenes"}, Words{"--help"},
                               Words{"build", "gen:soup:100", "--builder", "median"}}) {
        INFO(words[0]);
        const Outcome outcome = ToolProcess(words, {}, -1, full).wait();
        CHECK(outcome.exit_code == 1);
        CHECK_THAT(outcome.err, StartsWith("clbvh: error: cannot write") && Contains("No space left on device"));
    }
    close(full);
}
