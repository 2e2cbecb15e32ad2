#include "report/scene_report.hpp"

#include <fmt/core.h>

#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>
#include <utility>

#include "cli/interrupt.hpp"
#include "measure/machine.hpp"

namespace clbvh::tool {

void SceneReport::print(const std::string& text) const {
    if (!json_.leaves_standard_output()) return;
    fmt::print("{}", text);
    std::fflush(stdout);
}

void SceneReport::print_tables(const std::string& text) {
    if (!std::exchange(has_tables_, true)) {
        const std::string note = loading_.note();
        print(machine_line(describe_machine(), choice_.context) + (note.empty() ? "" : "\n" + note) + "\n\n");
    }
    print(text);
}

void SceneReport::add_unavailable(nlohmann::ordered_json& document) const {
    for (const std::string& id : choice_.unavailable_ids)
        document["unavailable"].push_back({{"builder", id}, {"reason", choice_.reason}});
}

void run_and_write(const JsonOutput& json, const std::function<void()>& work, const std::function<bool()>& has_results,
                   const std::function<nlohmann::ordered_json()>& document) {
    try {
        work();
    } catch (const std::exception& error) {
        if (has_results()) {
            nlohmann::ordered_json incomplete = document();
            incomplete["incomplete"] = interrupted() ? "interrupted" : error.what();
            json.write(incomplete);
        }
        throw;
    }
    json.write(document());
}

}  // namespace clbvh::tool
