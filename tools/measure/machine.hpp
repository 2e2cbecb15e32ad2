#pragma once

#include <clbvh/device/context.hpp>
#include <cstdint>
#include <istream>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace clbvh::tool {

/// A data cache of the first processor.
struct Cache {
    std::uint32_t level = 0;
    std::uint64_t bytes = 0;
};

/// Properties of the machine that measured times depend on, beside the device. Those that the system does not report
/// are absent.
struct Machine {
    std::optional<std::string> cpu;  ///< Model name.
    std::optional<std::uint32_t> logical_cores;
    std::optional<std::uint64_t> memory_bytes;
    std::vector<Cache> caches;          ///< From the first level on; empty where unknown.
    std::optional<std::string> os;      ///< For example "Debian GNU/Linux 12 (bookworm)".
    std::optional<std::string> kernel;  ///< For example "Linux 6.1.0 x86_64".
    std::string compiler;               ///< That compiled this program.
    std::string version;                ///< Of this program and the library.
    std::string date;                   ///< UTC, as in "2026-11-22T13:05:00Z".
};

/// The machine that this runs on, now.
[[nodiscard]] Machine describe_machine();

/// The same as an object of JSON, with the OpenCL platform, device and driver where `context` is open.
[[nodiscard]] nlohmann::ordered_json to_json(const Machine& machine, const std::optional<Context>& context);

/// The most important of it in one line, without the line's end.
[[nodiscard]] std::string machine_line(const Machine& machine, const std::optional<Context>& context);

/// The model name in the text of /proc/cpuinfo.
[[nodiscard]] std::optional<std::string> cpu_model_in(std::istream& text);
/// The pretty name in the text of /etc/os-release.
[[nodiscard]] std::optional<std::string> os_name_in(std::istream& text);

}  // namespace clbvh::tool
