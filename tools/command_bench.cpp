#include <fmt/core.h>

#include <algorithm>
#include <clbvh/io/scene.hpp>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bench_report.hpp"
#include "bench_scene.hpp"
#include "build_arguments.hpp"
#include "build_result.hpp"
#include "builder_choice.hpp"
#include "command.hpp"
#include "embree_peer.hpp"
#include "interrupt.hpp"
#include "json_output.hpp"
#include "progress_bar.hpp"
#include "result_json.hpp"
#include "scene_check.hpp"

namespace clbvh::tool {
namespace {

struct Arguments {
    std::vector<std::string> scenes;
    std::string builders = "all";
    bool peers = false;
    std::uint32_t runs = 5;
    bool unvalidated = false;
    BuildArguments build;
    JsonOutput json;
};

constexpr const char* kWayOut = "--builders host needs no device (see clbvh builders)";

/// A benchmark under way: tables are printed as scenes end, and the document holds what has been done so far.
class Bench {
public:
    explicit Bench(const Arguments& arguments)
        : arguments_(arguments),
          choice_(choose_builders(arguments.builders, arguments.build.device, kWayOut)),
          settings_{choice_.ids,    arguments.peers, arguments.runs, !arguments.unvalidated, arguments.build.options,
                    choice_.context} {}

    void run_scenes() {
        print(unavailable_report(choice_));
        ProgressBar bar;
        for (const std::string& scene : arguments_.scenes) {
            bar.show(0.0, "loading " + scene);
            const Mesh mesh = load_scene(scene);
            std::vector<BuildResult> of_scene = bench_scene(settings_, scene, mesh, bar);
            bar.erase();
            print(scene_report(choice_.context, of_scene) + peers_note() + '\n');
            std::move(of_scene.begin(), of_scene.end(), std::back_inserter(results_));
        }
        const std::size_t count = arguments_.scenes.size();
        if (count < 2) return;
        print(
            fmt::format("geometric means over {} scenes\n{}", count, means_report(results_, results_.size() / count)));
    }

    [[nodiscard]] std::span<const BuildResult> results() const { return results_; }

    /// With "unavailable" in it where some builders are.
    [[nodiscard]] nlohmann::ordered_json document() const {
        nlohmann::ordered_json document = to_json(choice_.context, arguments_.build.options, results_);
        for (const std::string& id : choice_.unavailable_ids)
            document["unavailable"].push_back({{"builder", id}, {"reason", choice_.reason}});
        return document;
    }

private:
    void print(const std::string& text) const {
        if (!arguments_.json.leaves_standard_output()) return;
        fmt::print("{}", text);
        std::fflush(stdout);
    }

    [[nodiscard]] std::string peers_note() const {
        const bool is_unequal = arguments_.peers && arguments_.build.options.presplit_level > 0;
        return is_unequal ? "Embree's builders ran without presplitting\n" : "";
    }

    const Arguments& arguments_;
    BuilderChoice choice_;
    BenchSettings settings_;
    std::vector<BuildResult> results_;
};

/// Keeps what a failed benchmark has measured, with the reason in "incomplete".
void save_incomplete(const Bench& bench, const JsonOutput& json, const std::string& reason) {
    if (bench.results().empty()) return;
    nlohmann::ordered_json document = bench.document();
    document["incomplete"] = reason;
    json.write(document);
    static_cast<void>(report_invalid_trees(bench.results()));
}

int run_bench(const Arguments& arguments) {
    arguments.build.check();
    if (arguments.peers) check_embree_peers(arguments.build.options);
    arguments.json.require_writable();
    std::ranges::for_each(arguments.scenes, require_scene);
    Bench bench(arguments);
    try {
        bench.run_scenes();
    } catch (const std::exception& error) {
        save_incomplete(bench, arguments.json, interrupted() ? "interrupted" : error.what());
        throw;
    }
    arguments.json.write(bench.document());
    return report_invalid_trees(bench.results());
}

/// CLI11's own check tells the range of a double.
std::string require_one_or_more(const std::string& value) {
    std::int64_t number = 0;
    return CLI::detail::lexical_cast(value, number) && number >= 1 ? "" : "must be at least 1";
}

}  // namespace

Command add_bench_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand("bench", "Time builders side by side, and a native sort beside them");
    auto arguments = std::make_shared<Arguments>();
    command->add_option("scene", arguments->scenes, "Mesh files, or gen:NAME[:COUNT[:SEED]]; see clbvh scenes")
        ->type_name("SCENE")
        ->required();
    command
        ->add_option("--builders", arguments->builders,
                     "Ids or groups (all, host, device) with commas between them; see clbvh builders")
        ->type_name("A,B,C")
        ->capture_default_str();
    command->add_flag("--peers", arguments->peers,
                      "Add Embree's builders, as host builders; of the options here they take --max-leaf, --budget, "
                      "the costs and --threads, no other, and no presplitting");
    command->add_option("--runs", arguments->runs, "Timed runs of each builder, after one that warms up")
        ->type_name("N")
        ->check(require_one_or_more)
        ->capture_default_str();
    command->add_flag("--no-validate", arguments->unvalidated, "Do not prove the trees right");
    arguments->build.add_options(*command);
    arguments->json.add_option(*command);
    return {command, [arguments] { return run_bench(*arguments); }};
}

}  // namespace clbvh::tool
