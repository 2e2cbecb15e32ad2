#include <fmt/core.h>

#include <clbvh/registry.hpp>
#include <memory>
#include <string>
#include <string_view>

#include "command.hpp"
#include "exit_code.hpp"
#include "json_output.hpp"
#include "table.hpp"

namespace clbvh::tool {
namespace {

std::string_view kind_name(BuilderKind kind) {
    return kind == BuilderKind::host ? "host" : "device";
}

int list(const JsonOutput& json) {
    json.require_writable();
    Table table({"builder", "runs on", "radius", "paper", "title"}, Table::Align::left);
    nlohmann::ordered_json entries = nlohmann::ordered_json::array();
    for (const BuilderInfo& builder : builders()) {
        table.add_row({std::string(builder.id), std::string(kind_name(builder.kind)),
                       builder.uses_search_radius ? "yes" : "no", std::string(builder.paper),
                       std::string(builder.title)});
        entries.push_back({{"id", builder.id},
                           {"title", builder.title},
                           {"paper", builder.paper},
                           {"kind", kind_name(builder.kind)},
                           {"uses_search_radius", builder.uses_search_radius}});
    }
    if (json.leaves_standard_output()) fmt::print("{}", table.text());
    json.write({{"builders", entries}});
    return kExitSuccess;
}

}  // namespace

Command add_builders_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand("builders", "List the builders");
    auto json = std::make_shared<JsonOutput>();
    json->add_option(*command);
    return {command, [json] { return list(*json); }};
}

}  // namespace clbvh::tool
