#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <clbvh/core/error.hpp>
#include <clbvh/device/device.hpp>
#include <clbvh/device/profile.hpp>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cli/exit_code.hpp"
#include "cli/json_output.hpp"
#include "commands/command.hpp"
#include "report/result_json.hpp"
#include "report/table.hpp"

namespace clbvh::tool {
namespace {

/// The device that a build without --device uses; none where CLBVH_DEVICE names a device that is not there, which must
/// not keep this command from showing what is.
std::optional<std::size_t> default_device() {
    try {
        return pick_device().index;
    } catch (const Error&) {
        return std::nullopt;
    }
}

Table device_table(const std::vector<DeviceInfo>& devices, std::optional<std::size_t> default_index) {
    Table table({"device", "default", "type", "units", "group", "local KiB", "memory MiB", "64-bit atomics", "platform",
                 "name"},
                Table::Align::left);
    for (const DeviceInfo& device : devices) {
        table.add_row({std::to_string(device.index), device.index == default_index ? "yes" : "",
                       std::string(to_string(device.type)), std::to_string(device.compute_units),
                       std::to_string(device.max_work_group_size), std::to_string(device.local_memory_bytes >> 10),
                       std::to_string(device.global_memory_bytes >> 20), device.int64_atomics ? "yes" : "no",
                       device.platform, device.name});
    }
    return table;
}

/// As find_profile(), but what is wrong with a file that CLBVH_PROFILE names becomes a reason, too.
FoundProfile profile_of(const DeviceInfo& device) {
    try {
        return find_profile(device);
    } catch (const Error& error) {
        const char* const named = std::getenv("CLBVH_PROFILE");
        return {named == nullptr ? "" : named, std::nullopt, error.what()};
    }
}

nlohmann::ordered_json profile_json(const FoundProfile& found) {
    nlohmann::ordered_json json{{"file", found.path.string()}, {"used", found.profile.has_value()}};
    if (!found.reason.empty()) json["reason"] = found.reason;
    return json;
}

/// One line for each device that has a profile.
std::string profile_lines(const std::vector<DeviceInfo>& devices) {
    std::string text;
    for (const DeviceInfo& device : devices) {
        const FoundProfile found = profile_of(device);
        if (found.profile) text += fmt::format("device {}: profile {}\n", device.index, found.path.string());
        if (!found.reason.empty()) {
            text +=
                fmt::format("device {}: profile {} is not used: {}\n", device.index, found.path.string(), found.reason);
        }
    }
    return text;
}

int print_devices(const JsonOutput& json) {
    json.require_writable();
    const std::vector<DeviceInfo> devices = list_devices();
    // The library's message for "none at all" says what to install.
    if (devices.empty()) static_cast<void>(pick_device());
    const std::optional<std::size_t> default_index = default_device();
    nlohmann::ordered_json entries = nlohmann::ordered_json::array();
    for (const DeviceInfo& device : devices) {
        entries.push_back(to_json(device));
        entries.back()["default"] = device.index == default_index;
        entries.back()["profile"] = profile_json(profile_of(device));
    }
    if (json.leaves_standard_output()) {
        fmt::print("{}{}", device_table(devices, default_index).text(), profile_lines(devices));
    }
    json.write({{"devices", entries}});
    return kExitSuccess;
}

}  // namespace

Command add_devices_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand("devices", "List the OpenCL devices");
    auto json = std::make_shared<JsonOutput>();
    json->add_option(*command);
    return {command, [json] { return print_devices(*json); }};
}

}  // namespace clbvh::tool
