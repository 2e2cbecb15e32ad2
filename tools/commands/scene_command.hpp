#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "cli/build_arguments.hpp"
#include "cli/builder_choice.hpp"
#include "cli/cli_fwd.hpp"
#include "cli/json_output.hpp"
#include "cli/progress_bar.hpp"
#include "cli/scene_arguments.hpp"
#include "rays/ray_arguments.hpp"
#include "rays/tracer_arguments.hpp"
#include "rays/view_arguments.hpp"
#include "report/scene_report.hpp"

namespace clbvh::tool {

inline constexpr const char* kBuildersHelp =
    "Ids or groups (all, host, device, presets) with commas between them; see clbvh builders";

/// The arguments of commands that run builders over scenes.
struct SceneCommandArguments {
    std::vector<std::string> scenes;
    SceneArguments loading;
    std::string builders = "all";
    BuildArguments build;
    JsonOutput json;

    /// Add options to a command; parsing fills this object.
    void add_scenes_and_builders(CLI::App& command, const std::string& builders_help);
    void add_loading_and_building(CLI::App& command);
    /// Throws what can be seen before any work.
    void check() const;
};

/// The same where rays are traced as well.
struct RayCommandArguments : SceneCommandArguments {
    ViewArguments view;
    RayArguments rays;
    TracerArguments tracing;

    void add_viewing_and_building(CLI::App& command);
    void check() const;
};

/// A command that works on one scene after the other. Tables are printed as scenes end, and the document holds what has
/// been done so far.
class SceneCommand {
public:
    SceneCommand(const SceneCommand&) = delete;
    SceneCommand& operator=(const SceneCommand&) = delete;
    virtual ~SceneCommand() = default;

    /// Returns the exit code. Where an exception ends the work, the document is written with what there is, faults are
    /// told all the same, and the exception goes on.
    int run();

protected:
    /// `arguments` outlive this object.
    SceneCommand(const SceneCommandArguments& arguments, BuilderChoice choice);

    [[nodiscard]] const BuilderChoice& choice() const { return choice_; }

    /// Printed before the first scene: which builders cannot run.
    [[nodiscard]] virtual std::string opening() const;
    /// Works on one scene, keeps the results, and returns its tables.
    [[nodiscard]] virtual std::string run_scene(const std::string& scene, ProgressBar& bar) = 0;
    /// Printed behind the last scene.
    [[nodiscard]] virtual std::string closing() const { return {}; }

    /// One element a result, so far.
    [[nodiscard]] virtual nlohmann::ordered_json results() const = 0;
    /// Adds what stands beside the results.
    virtual void add_fields(nlohmann::ordered_json& /*document*/) const {}
    /// Tells standard error what is wrong with the results, and returns the exit code.
    [[nodiscard]] virtual int report_faults() const = 0;

private:
    void run_scenes();
    [[nodiscard]] nlohmann::ordered_json document() const;

    const SceneCommandArguments& arguments_;
    BuilderChoice choice_;
    SceneReport report_;
};

/// The same where rays are traced as well.
class RaySceneCommand : public SceneCommand {
protected:
    /// `arguments` outlive this object.
    RaySceneCommand(const RayCommandArguments& arguments, BuilderChoice choice)
        : SceneCommand(arguments, std::move(choice)), arguments_(arguments) {}

    [[nodiscard]] std::string run_scene(const std::string& scene, ProgressBar& bar) final;
    /// As run_scene(), with the scene loaded.
    [[nodiscard]] virtual std::string run_viewed(const std::string& scene, const ViewedScene& viewed,
                                                 ProgressBar& bar) = 0;

private:
    const RayCommandArguments& arguments_;
};

}  // namespace clbvh::tool
