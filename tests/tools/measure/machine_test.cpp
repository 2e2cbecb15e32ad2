#include <clbvh/version.h>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <optional>
#include <sstream>
#include <string>

#include "measure/machine.hpp"
#include "tools/result_fields.hpp"
#include "tools/tool_process.hpp"

using namespace clbvh;
using namespace clbvh::test;
using namespace clbvh::tool;
using Catch::Matchers::Contains;
using nlohmann::ordered_json;

TEST_CASE("the processor's name is found, or is absent") {
    std::istringstream text("processor\t: 0\nmodel\t\t: 167\nmodel name\t: Some CPU @ 2: fast \nmodel name\t: Other\n");
    CHECK(cpu_model_in(text) == "Some CPU @ 2: fast");
    std::istringstream without("processor\t: 0\nBogoMIPS\t: 50.00\n");
    CHECK_FALSE(cpu_model_in(without));
    std::istringstream empty;
    CHECK_FALSE(cpu_model_in(empty));
}

TEST_CASE("the system's name loses its quotes") {
    std::istringstream quoted("NAME=\"Some\"\nPRETTY_NAME=\"Some System 1 (x)\"\n");
    CHECK(os_name_in(quoted) == "Some System 1 (x)");
    std::istringstream bare("PRETTY_NAME=Some\n");
    CHECK(os_name_in(bare) == "Some");
    std::istringstream quote("PRETTY_NAME=\"\n");
    CHECK(os_name_in(quote) == "\"");
}

TEST_CASE("what is not known of a machine is absent from its description") {
    Machine unknown;
    unknown.compiler = "cc";
    unknown.version = "1.2.3";
    unknown.date = "2026-01-02T03:04:05Z";
    CHECK(field_names(to_json(unknown, std::nullopt)) == std::vector<std::string>{"compiler", "version", "date"});
    CHECK(machine_line(unknown, std::nullopt) == "unknown CPU; clbvh 1.2.3, cc; 2026-01-02T03:04:05Z");
    Machine known = unknown;
    known.logical_cores = 1;
    known.memory_bytes = std::uint64_t{3} << 29;
    known.caches = {{1, 32768}, {2, 1 << 20}};
    const ordered_json json = to_json(known, std::nullopt);
    CHECK(json["logical_cores"] == 1);
    CHECK(json["caches"].size() == 2);
    CHECK(json["caches"][1]["level"] == 2);
    CHECK_THAT(machine_line(known, std::nullopt), Contains("; 1 logical core; 1.5 GiB; "));
}

TEST_CASE("this machine is described as it is") {
    const Machine machine = describe_machine();
    REQUIRE(machine.logical_cores);
    CHECK(*machine.logical_cores > 0);
    REQUIRE(machine.memory_bytes);
    CHECK(*machine.memory_bytes > (std::uint64_t{1} << 28));
    CHECK(machine.version == CLBVH_VERSION_STRING);
    CHECK_THAT(machine.compiler, Contains("gcc ") || Contains("clang "));
    const auto is_level_in_order = [](const Cache& a, const Cache& b) { return a.level < b.level; };
    CHECK(std::is_sorted(machine.caches.begin(), machine.caches.end(), is_level_in_order));
    REQUIRE(machine.date.size() == std::string("2026-11-22T13:05:00Z").size());
    for (const std::size_t digit : {0u, 3u, 5u, 6u, 8u, 9u, 11u, 12u, 14u, 15u, 17u, 18u})
        CHECK(std::isdigit(static_cast<unsigned char>(machine.date[digit])) != 0);
    CHECK(machine.date[10] == 'T');
    CHECK(machine.date.back() == 'Z');
}

TEST_CASE("build and bench tell which machine it was") {
    for (const char* command : {"build", "bench"}) {
        const std::string builders = std::string(command) == "build" ? "--builder" : "--builders";
        const Outcome outcome = run_tool({command, "gen:soup:100", builders, "lbvh", "--json", "-"});
        REQUIRE(outcome.exit_code == 0);
        const ordered_json document = ordered_json::parse(outcome.out);
        const ordered_json& machine = document["machine"];
        CHECK(machine["logical_cores"].get<unsigned>() == describe_machine().logical_cores);
        CHECK(machine["version"] == CLBVH_VERSION_STRING);
        CHECK(machine["opencl"]["device"] == document["device"]["name"]);
        CHECK(machine["opencl"]["driver_version"] == document["device"]["driver_version"]);
    }
    const Outcome text = run_tool({"bench", "gen:soup:100", "--builders", "median", "--runs", "1"});
    const Machine machine = describe_machine();
    CHECK_THAT(text.out.substr(0, text.out.find('\n')),
               Contains(machine.cpu.value_or("unknown CPU")) && Contains("clbvh " CLBVH_VERSION_STRING));
}
