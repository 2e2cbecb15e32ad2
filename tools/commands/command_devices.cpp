#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <clbvh/core/error.hpp>
#include <clbvh/device/context.hpp>
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

struct DevicesArguments {
    bool self_test = false;
    JsonOutput json;
};

/// The result of each device's self-test; empty where none was asked for.
std::vector<bool> self_tests(const std::vector<DeviceInfo>& devices, bool wanted) {
    std::vector<bool> passed;
    ContextOptions options;
    options.use_profile = false;
    for (const DeviceInfo& device : devices) {
        if (wanted) passed.push_back(Context::open(std::to_string(device.index), options).passes_hand_over_check());
    }
    return passed;
}

std::string self_test_lines(const std::vector<bool>& passed) {
    std::string text;
    for (std::size_t i = 0; i < passed.size(); ++i)
        text += fmt::format("device {}: self-test {}\n", i,
                            passed[i] ? "passed" : "failed: work groups cannot hand over within a launch");
    return text;
}

/// One line for each driver that fails.
std::string fault_lines(const std::vector<PlatformFault>& faults) {
    std::string text;
    for (const PlatformFault& fault : faults)
        text += fmt::format("{} is passed over: {}\n", fault.platform, fault.reason);
    return text;
}

int print_devices(const DevicesArguments& arguments) {
    const JsonOutput& json = arguments.json;
    json.require_writable();
    std::vector<PlatformFault> faults;
    const std::vector<DeviceInfo> devices = list_devices(&faults);
    // The library's message for "none at all" says what to install.
    if (devices.empty()) static_cast<void>(pick_device());
    const std::optional<std::size_t> default_index = default_device();
    const std::vector<bool> passed = self_tests(devices, arguments.self_test);
    nlohmann::ordered_json entries = nlohmann::ordered_json::array();
    for (const DeviceInfo& device : devices) {
        entries.push_back(to_json(device));
        entries.back()["default"] = device.index == default_index;
        entries.back()["profile"] = profile_json(profile_of(device));
        if (!passed.empty()) entries.back()["self_test_passed"] = static_cast<bool>(passed[device.index]);
    }
    if (json.leaves_standard_output()) {
        fmt::print("{}{}{}{}", device_table(devices, default_index).text(), fault_lines(faults), profile_lines(devices),
                   self_test_lines(passed));
    }
    nlohmann::ordered_json failing = nlohmann::ordered_json::array();
    for (const PlatformFault& fault : faults)
        failing.push_back({{"platform", fault.platform}, {"reason", fault.reason}});
    json.write({{"devices", entries}, {"failing_platforms", failing}});
    return std::ranges::find(passed, false) == passed.end() ? kExitSuccess : kExitFailure;
}

}  // namespace

Command add_devices_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand("devices", "List the OpenCL devices");
    auto arguments = std::make_shared<DevicesArguments>();
    command->add_flag("--self-test", arguments->self_test,
                      "Find out whether work groups of each can hand over to each other within a launch, ten million "
                      "times; what tune keeps in a profile");
    arguments->json.add_option(*command);
    return {command, [arguments] { return print_devices(*arguments); }};
}

}  // namespace clbvh::tool
