#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <clbvh/catalog.hpp>
#include <clbvh/core/error.hpp>
#include <clbvh/device/device.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/exit_code.hpp"
#include "cli/json_output.hpp"
#include "commands/command.hpp"
#include "measure/build_result.hpp"
#include "report/table.hpp"

namespace clbvh::tool {
namespace {

using nlohmann::ordered_json;

/// Why no device builder can run here; empty where they can.
std::string missing_device() {
    try {
        static_cast<void>(pick_device());
        return {};
    } catch (const Error& error) {
        return error.what();
    }
}

/// The options that this builder reads and some others do not.
std::vector<std::string_view> own_options(const BuilderInfo& builder) {
    std::vector<std::string_view> names;
    for (const OptionInfo& option : options()) {
        if (option.readers != "all" && reads_option(builder.id, option.name)) names.push_back(option.name);
    }
    return names;
}

bool runs_on_host(std::string_view id) {
    return find_builder(id).kind == BuilderKind::host;
}

std::string dash_unless(std::string_view value) {
    return std::string(value.empty() ? "-" : value);
}
std::string dash_unless(std::uint32_t value) {
    return value == 0 ? "-" : std::to_string(value);
}

/// A table for people, and the same as JSON.
struct Listing {
    explicit Listing(std::vector<std::string> header) : table(std::move(header), Table::Align::left) {}

    Table table;
    ordered_json entries = ordered_json::array();
};

/// `missing` is missing_device()'s.
Listing list_builders(const std::string& missing) {
    Listing listing({"builder", "runs on", "available", "paper", "title"});
    for (const BuilderInfo& builder : builders()) {
        const std::string_view reason = builder.kind == BuilderKind::device ? missing : std::string_view{};
        listing.table.add_row({std::string(builder.id), std::string(to_string(builder.kind)),
                               reason.empty() ? "yes" : "no", std::string(builder.paper), std::string(builder.title)});
        listing.entries.push_back({{"id", builder.id},
                                   {"title", builder.title},
                                   {"paper", builder.paper},
                                   {"kind", to_string(builder.kind)},
                                   {"options", own_options(builder)},
                                   {"available", reason.empty()}});
        if (!reason.empty()) listing.entries.back()["reason"] = reason;
    }
    return listing;
}

Listing list_optimizers() {
    Listing listing({"optimizer", "runs on", "paper", "title"});
    for (const OptimizerInfo& optimizer : optimizers()) {
        listing.table.add_row({std::string(optimizer.id), optimizer.on_device ? "host, device" : "host",
                               std::string(optimizer.paper), std::string(optimizer.title)});
        listing.entries.push_back({{"id", optimizer.id},
                                   {"title", optimizer.title},
                                   {"paper", optimizer.paper},
                                   {"splits_first", optimizer.splits_first},
                                   {"on_device", optimizer.on_device}});
    }
    return listing;
}

Listing list_presets(const std::string& missing) {
    Listing listing({"preset", "builder", "optimizers", "passes", "leaf size", "max leaf", "title"});
    for (const PresetInfo& preset : presets()) {
        listing.table.add_row({std::string(preset.id), std::string(preset.builder), dash_unless(preset.optimizers),
                               dash_unless(preset.optimize_passes), dash_unless(preset.leaf_size),
                               dash_unless(preset.max_leaf_size), std::string(preset.title)});
        listing.entries.push_back({{"id", preset.id},
                                   {"title", preset.title},
                                   {"builder", preset.builder},
                                   {"optimizers", preset.optimizers},
                                   {"optimize_passes", preset.optimize_passes},
                                   {"max_leaf_size", preset.max_leaf_size},
                                   {"leaf_size", preset.leaf_size},
                                   {"code_bits", preset.code_bits},
                                   {"split_overlap", preset.split_overlap},
                                   {"opening", to_string(preset.opening)},
                                   {"available", runs_on_host(preset.id) || missing.empty()}});
    }
    return listing;
}

int print_all(const JsonOutput& json) {
    json.require_writable();
    const std::string missing = missing_device();
    const Listing of_builders = list_builders(missing);
    const Listing of_optimizers = list_optimizers();
    const Listing of_presets = list_presets(missing);
    if (json.leaves_standard_output()) {
        fmt::print("{}\n{}\n{}", of_presets.table.text(), of_builders.table.text(), of_optimizers.table.text());
        if (!missing.empty()) fmt::print("\nWhat runs on a device is not available: {}\n", missing);
    }
    json.write(
        {{"builders", of_builders.entries}, {"optimizers", of_optimizers.entries}, {"presets", of_presets.entries}});
    return kExitSuccess;
}

}  // namespace

Command add_builders_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand("builders", "List the presets, the builders, and what improves their trees");
    auto json = std::make_shared<JsonOutput>();
    json->add_option(*command);
    return {command, [json] { return print_all(*json); }};
}

}  // namespace clbvh::tool
