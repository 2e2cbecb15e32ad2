#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "cli/builder_choice.hpp"
#include "cli/json_output.hpp"
#include "cli/scene_arguments.hpp"

namespace clbvh::tool {

/// Output of commands that run builders over scenes: text for people as scenes end, and one document.
class SceneReport {
public:
    /// All of them outlive this object.
    SceneReport(const BuilderChoice& choice, const SceneArguments& loading, const JsonOutput& json)
        : choice_(choice), loading_(loading), json_(json) {}

    /// Prints text for people where that does not get into the document's way.
    void print(const std::string& text) const;
    /// The same for a scene's tables; the machine and how scenes were turned stand above the first of them.
    void print_tables(const std::string& text);
    /// Adds the builders that could not run, and why.
    void add_unavailable(nlohmann::ordered_json& document) const;

private:
    const BuilderChoice& choice_;
    const SceneArguments& loading_;
    const JsonOutput& json_;
    bool has_tables_ = false;
};

/// Runs `work` and writes the document. Where `work` throws, what there is by then is written with the reason in
/// "incomplete", unless `has_results` says that it is nothing, and the exception goes on.
void run_and_write(const JsonOutput& json, const std::function<void()>& work, const std::function<bool()>& has_results,
                   const std::function<nlohmann::ordered_json()>& document);

}  // namespace clbvh::tool
