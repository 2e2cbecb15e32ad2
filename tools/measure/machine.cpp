#include "measure/machine.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <clbvh/version.h>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>

namespace clbvh::tool {
namespace {

std::optional<std::uint64_t> positive(long number) {
    if (number <= 0) return std::nullopt;
    return static_cast<std::uint64_t>(number);
}

std::optional<std::uint32_t> logical_cores() {
    const auto count = positive(sysconf(_SC_NPROCESSORS_ONLN));
    if (!count) return std::nullopt;
    return static_cast<std::uint32_t>(*count);
}

std::optional<std::uint64_t> memory_bytes() {
    const auto pages = positive(sysconf(_SC_PHYS_PAGES));
    const auto page = positive(sysconf(_SC_PAGESIZE));
    if (!pages || !page) return std::nullopt;
    return *pages * *page;
}

/// Description of a cache by the kernel, in `folder`: its level, its type and its size as in "48K".
std::optional<Cache> read_data_cache(const std::filesystem::path& folder) {
    Cache cache;
    std::string type;
    std::uint64_t kibibytes = 0;
    if (!(std::ifstream(folder / "level") >> cache.level)) return std::nullopt;
    if (!(std::ifstream(folder / "type") >> type) || type == "Instruction") return std::nullopt;
    if (!(std::ifstream(folder / "size") >> kibibytes)) return std::nullopt;
    cache.bytes = kibibytes << 10;
    return cache;
}

std::vector<Cache> caches() {
    const std::filesystem::path parent = "/sys/devices/system/cpu/cpu0/cache";
    std::vector<Cache> list;
    for (std::size_t i = 0; std::filesystem::exists(parent / fmt::format("index{}", i)); ++i) {
        if (const auto cache = read_data_cache(parent / fmt::format("index{}", i))) list.push_back(*cache);
    }
    return list;
}

std::optional<std::string> kernel_name() {
    utsname name{};
    if (uname(&name) != 0) return std::nullopt;
    return fmt::format("{} {} {}", name.sysname, name.release, name.machine);
}

std::string compiler_name() {
#if defined(__clang__)
    return fmt::format("clang {}.{}.{}", __clang_major__, __clang_minor__, __clang_patchlevel__);
#elif defined(__GNUC__)
    return "gcc " __VERSION__;
#else
    return "unknown";
#endif
}

std::string utc_now() {
    const std::time_t now = std::time(nullptr);
    std::tm utc{};
    gmtime_r(&now, &utc);
    return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday,
                       utc.tm_hour, utc.tm_min, utc.tm_sec);
}

std::string_view without_blanks_around(std::string_view text) {
    constexpr std::string_view blanks = " \t";
    const std::size_t begin = std::min(text.find_first_not_of(blanks), text.size());
    return text.substr(begin, text.find_last_not_of(blanks) + 1 - begin);
}

/// The first value of `key` in lines of "key SEPARATOR value".
std::optional<std::string> value_in(std::istream& text, std::string_view key, char separator) {
    for (std::string line; std::getline(text, line);) {
        const std::size_t end = line.find(separator);
        if (end == std::string::npos) continue;
        if (without_blanks_around(std::string_view(line).substr(0, end)) != key) continue;
        return std::string(without_blanks_around(std::string_view(line).substr(end + 1)));
    }
    return std::nullopt;
}

std::string cores_text(std::uint32_t count) {
    return fmt::format("{} logical core{}", count, count == 1 ? "" : "s");
}

template <typename Value>
void set_where_known(nlohmann::ordered_json& json, const char* name, const std::optional<Value>& value) {
    if (value) json[name] = *value;
}

}  // namespace

std::optional<std::string> cpu_model_in(std::istream& text) {
    return value_in(text, "model name", ':');
}

std::optional<std::string> os_name_in(std::istream& text) {
    std::optional<std::string> name = value_in(text, "PRETTY_NAME", '=');
    if (name && name->size() >= 2 && name->front() == '"' && name->back() == '"') {
        name = name->substr(1, name->size() - 2);
    }
    return name;
}

Machine describe_machine() {
    std::ifstream cpuinfo("/proc/cpuinfo");
    std::ifstream os_release("/etc/os-release");
    Machine machine;
    machine.cpu = cpu_model_in(cpuinfo);
    machine.logical_cores = logical_cores();
    machine.memory_bytes = memory_bytes();
    machine.caches = caches();
    machine.os = os_name_in(os_release);
    machine.kernel = kernel_name();
    machine.compiler = compiler_name();
    machine.version = clbvh_version_string();
    machine.date = utc_now();
    return machine;
}

nlohmann::ordered_json to_json(const Machine& machine, const std::optional<Context>& context) {
    nlohmann::ordered_json json;
    set_where_known(json, "cpu", machine.cpu);
    set_where_known(json, "logical_cores", machine.logical_cores);
    set_where_known(json, "memory_bytes", machine.memory_bytes);
    for (const Cache& cache : machine.caches)
        json["caches"].push_back({{"level", cache.level}, {"bytes", cache.bytes}});
    set_where_known(json, "os", machine.os);
    set_where_known(json, "kernel", machine.kernel);
    json["compiler"] = machine.compiler;
    json["version"] = machine.version;
    if (context) {
        const DeviceInfo& device = context->device();
        json["opencl"] = {
            {"platform", device.platform}, {"device", device.name}, {"driver_version", device.driver_version}};
    }
    json["date"] = machine.date;
    return json;
}

std::string machine_line(const Machine& machine, const std::optional<Context>& context) {
    std::vector<std::string> parts;
    parts.push_back(machine.cpu.value_or("unknown CPU"));
    if (machine.logical_cores) parts.push_back(cores_text(*machine.logical_cores));
    if (machine.memory_bytes)
        parts.push_back(fmt::format("{:.1f} GiB", static_cast<double>(*machine.memory_bytes) / (1 << 30)));
    if (machine.os) parts.push_back(*machine.os);
    if (machine.kernel) parts.push_back(*machine.kernel);
    if (context) parts.push_back(fmt::format("{} {}", context->device().platform, context->device().driver_version));
    parts.push_back(fmt::format("clbvh {}, {}", machine.version, machine.compiler));
    parts.push_back(machine.date);
    return fmt::format("{}", fmt::join(parts, "; "));
}

}  // namespace clbvh::tool
