#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <clbvh/options.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "cli/exit_code.hpp"
#include "cli/json_output.hpp"
#include "commands/command.hpp"
#include "report/table.hpp"

namespace clbvh::tool {
namespace {

using nlohmann::ordered_json;

struct OptionsArguments {
    bool markdown = false;
    JsonOutput json;
};

constexpr std::string_view kOptionTypes[] = {"whole", "real", "boolean", "choice", "text"};

/// The default, where there is one to show.
std::string default_text(const OptionInfo& option) {
    return option.default_value.empty() ? "-" : option.default_value;
}

std::string options_text() {
    Table table({"option", "flag", "takes", "default", "read by"}, Table::Align::left);
    for (const OptionInfo& option : options())
        table.add_row({std::string(option.name), std::string(option.flag), option.values, default_text(option),
                       std::string(option.readers)});
    return table.text();
}

/// A table for each group, for docs/options.md.
std::string options_markdown() {
    std::string page;
    std::string_view group;
    for (const OptionInfo& option : options()) {
        if (option.group != group) {
            group = option.group;
            page += fmt::format(
                "\n## {}\n\n| option | flag | takes | default | read by | what |\n|---|---|---|---|---|---|\n", group);
        }
        page += fmt::format("| `{}` | `{}` | {} | {} | {} | {} |\n", option.name, option.flag, option.values,
                            default_text(option), option.readers, option.help);
    }
    return page;
}

ordered_json option_entries() {
    ordered_json list = ordered_json::array();
    for (const OptionInfo& option : options()) {
        list.push_back({{"name", option.name},
                        {"flag", option.flag},
                        {"group", option.group},
                        {"type", kOptionTypes[static_cast<std::size_t>(option.type)]},
                        {"values", option.values},
                        {"default", option.default_value},
                        {"readers", option.readers},
                        {"help", option.help}});
    }
    return list;
}

int list_options(const OptionsArguments& arguments) {
    arguments.json.require_writable();
    if (arguments.json.leaves_standard_output())
        fmt::print("{}", arguments.markdown ? options_markdown() : options_text());
    arguments.json.write({{"options", option_entries()}});
    return kExitSuccess;
}

}  // namespace

Command add_options_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand("options", "List the options of builds, and which builders read them");
    auto arguments = std::make_shared<OptionsArguments>();
    command->add_flag("--markdown", arguments->markdown, "Print them as docs/options.md has them");
    arguments->json.add_option(*command);
    return {command, [arguments] { return list_options(*arguments); }};
}

}  // namespace clbvh::tool
