#include <catch2/catch.hpp>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "tools/scratch_folder.hpp"
#include "tools/tool_process.hpp"

using namespace clbvh::test;
using Catch::Matchers::Contains;

namespace {

struct Plotted {
    bool success;
    std::string text;  // standard output and error
};

/// Runs a program of the shell's and collects what it prints.
Plotted run_shell(const std::string& command) {
    Plotted result{false, {}};
    std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
    REQUIRE(pipe != nullptr);
    for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe))
        result.text += static_cast<char>(c);
    result.success = pclose(pipe) == 0;
    return result;
}

Plotted plot(const std::string& arguments) {
    return run_shell(CLBVH_PYTHON " " CLBVH_PLOT " " + arguments);
}

/// True where figures can be drawn; else says why not.
bool can_plot() {
    if (run_shell(CLBVH_PYTHON " -c 'import matplotlib'").success) return true;
    WARN("skipped: " CLBVH_PYTHON " has no matplotlib (Debian: python3-matplotlib)");
    return false;
}

bool is_png(const std::string& path) {
    return read_text(path).starts_with("\x89PNG");
}

void bench(const std::string& json, std::vector<std::string> words) {
    words.insert(words.begin(), "bench");
    words.insert(words.end(), {"--runs", "1", "--no-validate", "--json", json});
    REQUIRE(run_tool(words).exit_code == 0);
}

}  // namespace

TEST_CASE("every figure is drawn from what bench writes") {
    if (!can_plot()) return;
    const ScratchFolder folder;
    const std::string json = folder.path("bench.json");
    bench(json, {"gen:soup:1000", "gen:line:1000", "--builders", "ploc,lbvh,binned-sah", "--max-leaf", "4"});
    for (const char* figure : {"builders", "stages", "speed", "bandwidth"}) {
        const std::string png = folder.path(std::string(figure) + ".png");
        const std::string options = std::string(figure) == "stages" ? " --scenes gen:line:1000" : "";
        const Plotted plotted = plot(figure + options + " " + json + " " + png);
        INFO(plotted.text);
        CHECK(plotted.success);
        CHECK(is_png(png));
    }
}

TEST_CASE("builders are drawn over what rays cost, and some joined by a line") {
    if (!can_plot()) return;
    const ScratchFolder folder;
    const std::string json = folder.path("rays.json"), png = folder.path("rays.png");
    bench(json, {"gen:soup:1000", "--builders", "high,highest,median", "--rays"});
    for (const char* cost : {"sah", "binary_ns_per_ray", "ns_per_ray"}) {
        const Plotted plotted =
            plot("builders --baseline high --line high,highest --cost " + (cost + (" " + json)) + " " + png);
        INFO(plotted.text);
        CHECK(plotted.success);
        CHECK(is_png(png));
    }
}

TEST_CASE("every sweep is drawn") {
    if (!can_plot()) return;
    const ScratchFolder folder;
    const std::string json = folder.path("size.json");
    bench(json, {"gen:soup:20000", "--sweep", "size", "--builders", "lbvh,median"});
    CHECK(plot("sweep " + json + " " + json + ".png").success);
    CHECK(is_png(json + ".png"));
    // Of an option: the same results, named so. Costs differ between them, which asks for a second panel.
    std::string of_radius = read_text(json);
    for (std::size_t at = of_radius.find("\"size\""); at != std::string::npos; at = of_radius.find("\"size\""))
        of_radius.replace(at, 6, "\"radius\"");
    std::ofstream(folder.path("radius.json")) << of_radius;
    const Plotted plotted = plot("sweep " + folder.path("radius.json") + " " + folder.path("radius.png"));
    INFO(plotted.text);
    CHECK(plotted.success);
    CHECK(is_png(folder.path("radius.png")));
    const Plotted wrong = plot("stages " + json + " " + folder.path("wrong.png"));
    CHECK_FALSE(wrong.success);
    CHECK_THAT(wrong.text, Contains("holds a sweep"));
}

TEST_CASE("rays and predictions are drawn from what metrics writes") {
    if (!can_plot()) return;
    const ScratchFolder folder;
    const std::string json = folder.path("metrics.json");
    REQUIRE(run_tool({"metrics", "gen:city:1000", "gen:soup:500", "--builders", "binned-sah,sbvh,median,aac-fast",
                      "--count", "1000", "--runs", "1", "--json", json})
                .exit_code == 0);
    const std::string png = folder.path("figure.png");
    for (const char* figure : {"rays", "rays --leave-out median --rays diffuse --scenes gen:soup:500", "predict",
                               "predict --measurement ns_per_ray --scenes gen:city:1000"}) {
        const Plotted plotted = plot(std::string(figure) + " " + json + " " + png);
        INFO(plotted.text);
        CHECK(plotted.success);
        CHECK(is_png(png));
    }
    const std::string tables = CLBVH_PYTHON " $(dirname " CLBVH_PLOT ")/ray_cost.py ";
    const Plotted page = run_shell(tables + json);
    CHECK(page.success);
    for (const char* part : {"# What rays cost", "| gen:soup:500 |", "**weights shared**", "| `sbvh` |"})
        CHECK_THAT(page.text, Contains(part));
    const auto refused = [&](const std::string& arguments, const std::string& part) {
        const Plotted plotted = plot(arguments + " " + json + " " + png);
        CHECK_FALSE(plotted.success);
        CHECK_THAT(plotted.text, Contains("error: ") && Contains(part) && !Contains("Traceback"));
    };
    refused("rays --rays shadow", "has no shadow rays; it has diffuse");
    refused("rays --baseline lbvh", "has no lbvh");
    refused("predict --leave-out median", "has 3 builders to show on gen:city:1000");
    const std::string builds = folder.path("builds.json");
    bench(builds, {"gen:soup:500", "--builders", "median"});
    CHECK_THAT(run_shell(tables + builds).text, Contains("holds no metrics") && !Contains("Traceback"));
    CHECK_THAT(plot("rays " + builds + " " + png).text, Contains("has no rays"));
    CHECK_THAT(plot("predict " + builds + " " + png).text, Contains("has no EPO"));
}

TEST_CASE("figures say what their JSON lacks") {
    if (!can_plot()) return;
    const ScratchFolder folder;
    const std::string json = folder.path("host.json");
    bench(json, {"gen:soup:500", "--builders", "median"});
    std::ofstream(folder.path("text.json")) << "no JSON";
    std::ofstream(folder.path("other.json")) << "{\"devices\": []}";
    std::ofstream(folder.path("parts.json"))
        << "{\"first\": " << read_text(json) << ", \"second\": " << read_text(json) << "}";
    const auto expect_failure = [&](const std::string& arguments, const std::string& part) {
        const Plotted plotted = plot(arguments + " " + folder.path("out.png"));
        INFO(plotted.text);
        CHECK_FALSE(plotted.success);
        CHECK_THAT(plotted.text,
                   Contains("plot.py") && Contains("error: ") && Contains(part) && !Contains("Traceback"));
    };
    expect_failure("stages " + json, "has no device builder");
    expect_failure("bandwidth " + json, "has no device builder");
    expect_failure("builders " + json, "has no binned-sah on gen:soup:500");
    expect_failure("builders --baseline median --cost ns_per_ray " + json, "run clbvh bench with --rays");
    expect_failure("speed " + json + " --baseline lbvh", "has no lbvh");
    expect_failure("speed " + json + " --baseline median --scenes gen:line", "has no scene 'gen:line'");
    expect_failure("sweep " + json, "holds no sweep");
    expect_failure("speed " + folder.path("text.json"), "text.json is no JSON");
    expect_failure("speed " + folder.path("other.json"), "other.json has no results");
    expect_failure("speed " + folder.path("absent.json"), "cannot read");
    expect_failure("speed " + folder.path("parts.json"), "has first, second; choose one with --part");
    CHECK(plot("speed --baseline median --part second " + folder.path("parts.json") + " " + folder.path("out.png"))
              .success);
    CHECK_THAT(plot("--help").text, Contains("bandwidth") && Contains("sweep") && Contains("predict"));
}
