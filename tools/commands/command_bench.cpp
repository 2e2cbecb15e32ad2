#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <clbvh/core/error.hpp>
#include <cstdint>
#include <exception>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bench/bench_scene.hpp"
#include "cli/build_arguments.hpp"
#include "cli/builder_choice.hpp"
#include "cli/json_output.hpp"
#include "cli/progress_bar.hpp"
#include "cli/scene_arguments.hpp"
#include "cli/scene_check.hpp"
#include "commands/command.hpp"
#include "embree/embree_peer.hpp"
#include "measure/build_result.hpp"
#include "rays/view_arguments.hpp"
#include "report/bench_report.hpp"
#include "report/result_json.hpp"
#include "report/scene_report.hpp"
#include "report/stage_report.hpp"
#include "sweep/sweep.hpp"
#include "sweep/sweep_report.hpp"
#include "sweep/sweep_scene.hpp"

namespace clbvh::tool {
namespace {

struct BenchArguments {
    std::vector<std::string> scenes;
    SceneArguments loading;
    std::string builders = "all";
    bool peers = false;
    std::uint32_t runs = 5;
    bool unvalidated = false;
    bool stages = false;
    bool rays = false;
    std::string sweep;           // empty where none was asked for
    std::uint32_t sweep_to = 0;  // 0 where it was not given
    BuildArguments build;
    JsonOutput json;
};

/// A benchmark under way: tables are printed as scenes end, and the document holds what has been done so far.
class Bench {
public:
    explicit Bench(const BenchArguments& arguments)
        : arguments_(arguments),
          choice_(choose_builders(arguments.builders, arguments.build.device, kBuildersWayOut)),
          sweep_(arguments.sweep.empty() ? nullptr : &find_sweep(arguments.sweep)) {
        if (sweep_ != nullptr) keep_readers(*sweep_, arguments.build.options, choice_);
        settings_ = {choice_.ids,
                     arguments.peers,
                     arguments.runs,
                     !arguments.unvalidated,
                     arguments.build.options,
                     choice_.context,
                     arguments.loading,
                     {}};
    }

    void run() {
        report_.print(unavailable_report(choice_));
        if (sweep_ != nullptr) {
            run_sweeps();
        } else {
            run_scenes();
        }
    }

    [[nodiscard]] std::span<const BuildResult> results() const { return results_; }

    /// With "unavailable" in it where some builders are.
    [[nodiscard]] nlohmann::ordered_json document() const {
        nlohmann::ordered_json document =
            to_json(choice_.context, arguments_.loading, arguments_.build.options, results_);
        report_.add_unavailable(document);
        return document;
    }

private:
    void run_scenes() {
        ProgressBar bar;
        for (const std::string& scene : arguments_.scenes) {
            bar.show(0.0, "loading " + scene);
            const Mesh mesh = load(scene);
            std::vector<BuildResult> of_scene = bench_scene(settings_, scene, mesh, bar);
            bar.erase();
            report_.print_tables(scene_report(choice_.context, of_scene) + peers_note(of_scene) + '\n');
            if (arguments_.stages) report_.print(stage_report(of_scene) + '\n');
            std::move(of_scene.begin(), of_scene.end(), std::back_inserter(results_));
        }
        const std::size_t count = arguments_.scenes.size();
        if (count < 2) return;
        report_.print(
            fmt::format("geometric means over {} scenes\n{}", count, means_report(results_, results_.size() / count)));
    }

    /// The scene and, where rays are traced, from where they come.
    Mesh load(const std::string& scene) {
        if (!arguments_.rays) return arguments_.loading.load(scene);
        ViewedScene viewed =
            load_viewed(scene, arguments_.loading, ViewArguments(), arguments_.build.options.thread_count);
        settings_.camera = viewed.camera;
        return std::move(viewed.mesh);
    }

    void run_sweeps() {
        ProgressBar bar;
        for (const std::string& scene : arguments_.scenes) {
            const std::vector<std::uint32_t> values =
                sweep_->values.empty() ? sweep_sizes(scene, arguments_.sweep_to) : sweep_->values;
            std::vector<BuildResult> of_scene = sweep_scene(settings_, *sweep_, values, scene, bar);
            bar.erase();
            report_.print_tables(sweep_report(scene, of_scene) + '\n');
            std::move(of_scene.begin(), of_scene.end(), std::back_inserter(results_));
        }
    }

    /// A preset has optimizers, and an optimizer a quota of splits, without an option that says so.
    [[nodiscard]] std::string peers_note(std::span<const BuildResult> of_scene) const {
        const bool is_unequal =
            arguments_.build.options.presplit_level > 0 || std::ranges::any_of(of_scene, [](const BuildResult& result) {
                return result.options && (result.options->split_quota > 0.0f || !result.options->optimizers.empty());
            });
        return arguments_.peers && is_unequal ? "Embree's builders ran without presplitting and optimizers\n" : "";
    }

    const BenchArguments& arguments_;
    BuilderChoice choice_;
    SceneReport report_{choice_, arguments_.loading, arguments_.json};
    const Sweep* sweep_;  // null where none was asked for
    BenchSettings settings_;
    std::vector<BuildResult> results_;
};

/// What can be seen before any work.
void check_arguments(const BenchArguments& arguments) {
    const auto refuse = [](const char* what) { throw Error(ErrorCode::invalid_input, what); };
    const bool sweeps = !arguments.sweep.empty();
    arguments.build.check();
    if (sweeps && arguments.peers) refuse("--peers: a sweep is of clbvh's own builders; leave --peers or --sweep out");
    if (sweeps && arguments.stages) refuse("--stages: a sweep's table has no stages (its JSON has); leave one out");
    if (sweeps && arguments.rays) refuse("--rays: a sweep traces no rays; leave --rays or --sweep out");
    if (arguments.sweep_to > 0 && arguments.sweep != "size") refuse("--sweep-to is for --sweep size");
    if (arguments.peers) check_embree_peers(arguments.build.options);
    arguments.json.require_writable();
    std::ranges::for_each(arguments.scenes, require_scene);
    if (arguments.sweep != "size") return;
    for (const std::string& scene : arguments.scenes)
        static_cast<void>(sweep_sizes(scene, arguments.sweep_to));
}

int run_bench(const BenchArguments& arguments) {
    check_arguments(arguments);
    Bench bench(arguments);
    try {
        run_and_write(
            arguments.json, [&] { bench.run(); }, [&] { return !bench.results().empty(); },
            [&] { return bench.document(); });
    } catch (const std::exception&) {
        static_cast<void>(report_invalid_trees(bench.results()));
        throw;
    }
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
    auto arguments = std::make_shared<BenchArguments>();
    command->add_option("scene", arguments->scenes, kScenesHelp)->type_name("SCENE")->required();
    command
        ->add_option("--builders", arguments->builders,
                     "Ids or groups (all, host, device, presets) with commas between them; see clbvh builders")
        ->type_name("A,B,C")
        ->capture_default_str();
    command->add_flag(
        "--peers", arguments->peers,
        "Add Embree's builders, as host builders; of the options here they take --max-leaf, --budget, "
        "the costs and --threads, no other, and no presplitting; embree-commit-low takes --threads alone");
    command->add_option("--runs", arguments->runs, "Timed runs of each builder, after one that warms up")
        ->type_name("N")
        ->check(require_one_or_more)
        ->capture_default_str();
    command->add_flag("--no-validate", arguments->unvalidated, "Do not prove the trees right");
    command->add_flag("--stages", arguments->stages,
                      "Show the stages of device builders: time, bytes moved, and their speed beside a copy's");
    command
        ->add_option("--sweep", arguments->sweep,
                     "Run the builders that read it at many values of one option (its own value is not read then), or "
                     "over generated scenes of many sizes")
        ->check(CLI::IsMember(sweep_names()))
        ->type_name("NAME");
    command
        ->add_option("--sweep-to", arguments->sweep_to,
                     "Most triangles of --sweep size; the scene's COUNT unless given")
        ->check(CLI::Range(std::uint32_t{1}, static_cast<std::uint32_t>(kMaxPrimitives)))
        ->type_name("N");
    command->add_flag("--rays", arguments->rays,
                      "Trace diffuse rays through the trees as well, on the host; see clbvh trace");
    arguments->loading.add_options(*command);
    arguments->build.add_options(*command);
    arguments->json.add_option(*command);
    return {command, [arguments] { return run_bench(*arguments); }};
}

}  // namespace clbvh::tool
