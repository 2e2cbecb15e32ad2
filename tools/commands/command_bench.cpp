#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <clbvh/core/error.hpp>
#include <cstdint>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bench/bench_scene.hpp"
#include "bench/first_ray_scene.hpp"
#include "commands/command.hpp"
#include "commands/scene_command.hpp"
#include "embree/embree_peer.hpp"
#include "measure/build_result.hpp"
#include "report/bench_report.hpp"
#include "report/first_ray_report.hpp"
#include "report/result_json.hpp"
#include "report/stage_report.hpp"
#include "sweep/sweep.hpp"
#include "sweep/sweep_report.hpp"
#include "sweep/sweep_scene.hpp"

namespace clbvh::tool {
namespace {

struct BenchArguments : SceneCommandArguments {
    bool peers = false;
    std::uint32_t runs = 5;
    bool unvalidated = false;
    bool stages = false;
    bool rays = false;
    bool first_ray = false;
    std::string sweep;           // empty where none was asked for
    std::uint32_t sweep_to = 0;  // 0 where it was not given
};

/// Null where no sweep was asked for.
const Sweep* sweep_of(const BenchArguments& arguments) {
    return arguments.sweep.empty() ? nullptr : &find_sweep(arguments.sweep);
}

BuilderChoice choose_for_bench(const BenchArguments& arguments) {
    BuilderChoice choice = choose_builders(arguments.builders, arguments.build.device, kBuildersWayOut);
    if (const Sweep* const sweep = sweep_of(arguments)) keep_readers(*sweep, choice);
    if (!arguments.peers) arguments.build.note_unread(choice.ids);  // peers read some that no builder here may
    return choice;
}

class Bench final : public SceneCommand {
public:
    explicit Bench(const BenchArguments& arguments)
        : SceneCommand(arguments, choose_for_bench(arguments)),
          arguments_(arguments),
          sweep_(sweep_of(arguments)),
          settings_{choice().ids,
                    arguments.peers,
                    arguments.runs,
                    !arguments.unvalidated,
                    arguments.build.options,
                    choice().context,
                    arguments.loading,
                    {}} {}

private:
    std::string run_scene(const std::string& scene, ProgressBar& bar) override {
        std::vector<BuildResult> of_scene = sweep_ != nullptr ? run_sweep(scene, bar) : run_builders(scene, bar);
        std::string tables = sweep_ != nullptr ? sweep_report(scene, of_scene)
                                               : scene_report(choice().context, of_scene) + peers_note(of_scene);
        if (arguments_.stages) tables += '\n' + stage_report(of_scene);
        std::ranges::move(of_scene, std::back_inserter(results_));
        return tables;
    }

    std::vector<BuildResult> run_builders(const std::string& scene, ProgressBar& bar) {
        bar.show(0.0, "loading " + scene);
        const Mesh mesh = load(scene);
        return bench_scene(settings_, scene, mesh, bar);
    }

    std::vector<BuildResult> run_sweep(const std::string& scene, ProgressBar& bar) const {
        return sweep_scene(settings_, *sweep_,
                           sweep_->values.empty() ? sweep_sizes(scene, arguments_.sweep_to) : sweep_->values, scene,
                           bar);
    }

    /// The scene and, where rays are traced, from where they come.
    Mesh load(const std::string& scene) {
        if (!arguments_.rays) return arguments_.loading.load(scene);
        ViewedScene viewed =
            load_viewed(scene, arguments_.loading, ViewArguments(), arguments_.build.options.thread_count);
        settings_.camera = viewed.camera;
        return std::move(viewed.mesh);
    }

    /// A preset has optimizers, and an optimizer a quota of splits, without an option that says so.
    [[nodiscard]] std::string peers_note(std::span<const BuildResult> of_scene) const {
        const bool is_unequal =
            arguments_.build.options.presplit_level > 0 || std::ranges::any_of(of_scene, [](const BuildResult& result) {
                return result.options && (result.options->split_quota > 0.0f || !result.options->optimizers.empty());
            });
        return arguments_.peers && is_unequal ? "Embree's builders ran without presplitting and optimizers\n" : "";
    }

    [[nodiscard]] std::string closing() const override {
        const std::size_t count = arguments_.scenes.size();
        if (sweep_ != nullptr || count < 2) return {};
        return fmt::format("geometric means over {} scenes\n{}", count,
                           means_report(results_, results_.size() / count));
    }

    [[nodiscard]] nlohmann::ordered_json results() const override { return to_json(results_); }

    [[nodiscard]] int report_faults() const override { return report_invalid_trees(results_); }

    const BenchArguments& arguments_;
    const Sweep* sweep_;  // null where none was asked for
    BenchSettings settings_;
    std::vector<BuildResult> results_;
};

/// From the caller's arrays to an answered ray.
class FirstRayBench final : public SceneCommand {
public:
    explicit FirstRayBench(const BenchArguments& arguments)
        : SceneCommand(arguments, choose_for_bench(arguments)), arguments_(arguments) {
        settings_.builders = choice().ids;
        settings_.peers = arguments.peers;
        settings_.runs = arguments.runs;
        settings_.options = arguments.build.options;
        settings_.context = choice().context;
    }

private:
    std::string run_scene(const std::string& scene, ProgressBar& bar) override {
        bar.show(0.0, "loading " + scene);
        const ViewedScene viewed =
            load_viewed(scene, arguments_.loading, ViewArguments(), arguments_.build.options.thread_count);
        const std::vector<FirstRayResult> of_scene = first_ray_scene(settings_, scene, viewed.mesh, viewed.camera, bar);
        results_.insert(results_.end(), of_scene.begin(), of_scene.end());
        return of_scene.empty() ? "" : first_ray_report(of_scene);
    }

    [[nodiscard]] std::string closing() const override {
        const std::size_t count = arguments_.scenes.size();
        if (count < 2 || results_.empty()) return {};
        return fmt::format("geometric means over {} scenes, milliseconds a million triangles\n{}", count,
                           first_ray_means(results_, results_.size() / count));
    }

    [[nodiscard]] nlohmann::ordered_json results() const override { return to_json(results_); }
    [[nodiscard]] int report_faults() const override { return 0; }

    const BenchArguments& arguments_;
    BenchSettings settings_;
    std::vector<FirstRayResult> results_;
};

/// Refuses wrong arguments before any work.
void check_arguments(const BenchArguments& arguments) {
    const auto refuse = [](const char* what) { throw Error(ErrorCode::invalid_input, what); };
    const bool sweeps = !arguments.sweep.empty();
    if (sweeps && arguments.peers) refuse("--peers: a sweep is of clbvh's own builders; leave --peers or --sweep out");
    if (sweeps && arguments.stages) refuse("--stages: a sweep's table has no stages (its JSON has); leave one out");
    if (sweeps && arguments.rays) refuse("--rays: a sweep traces no rays; leave --rays or --sweep out");
    if (arguments.first_ray && (sweeps || arguments.stages || arguments.rays || arguments.unvalidated)) {
        refuse(
            "--first-ray: a benchmark of its own, which traces rays and shows stages in its JSON; leave --sweep, "
            "--stages, --rays and --no-validate out");
    }
    if (arguments.sweep_to > 0 && arguments.sweep != "size") refuse("--sweep-to is for --sweep size");
    if (arguments.peers) check_embree_peers(arguments.build.options);
    arguments.check();
    if (arguments.sweep != "size") return;
    for (const std::string& scene : arguments.scenes)
        static_cast<void>(sweep_sizes(scene, arguments.sweep_to));
}

int run_bench(const BenchArguments& arguments) {
    check_arguments(arguments);
    if (arguments.first_ray) return FirstRayBench(arguments).run();
    return Bench(arguments).run();
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
    arguments->add_scenes_and_builders(*command, kBuildersHelp);
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
    command->add_flag(
        "--first-ray", arguments->first_ray,
        "Time the way from the mesh's arrays to an answered ray, and then rays on one thread; the presets "
        "unless --builders names others; with --peers beside Embree's scenes");
    arguments->add_loading_and_building(*command);
    return {command, [arguments] {
                if (arguments->first_ray && arguments->builders == SceneCommandArguments().builders)
                    arguments->builders = "presets";
                return run_bench(*arguments);
            }};
}

}  // namespace clbvh::tool
