#include "device/opencl/program_cache.hpp"

#include <cstddef>
#include <fstream>
#include <string_view>
#include <vector>

#include "clbvh/core/error.hpp"
#include "core/fnv1a.hpp"
#include "device/opencl/user_folder.hpp"

namespace clbvh::device {
namespace {

namespace fs = std::filesystem;

/// The processor's features, as Linux lists them: CPU drivers compile for it, and home folders are shared.
std::string processor_flags() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);) {
        if (line.starts_with("flags") || line.starts_with("Features")) return line;
    }
    return {};
}

ProgramCaching caching_variable() {
    const std::string_view value = environment("CLBVH_CACHE");
    if (value == "on") return ProgramCaching::on;
    if (value == "off") return ProgramCaching::off;
    if (value.empty() || value == "auto") return ProgramCaching::automatic;
    throw Error(ErrorCode::invalid_input, "CLBVH_CACHE is '" + std::string(value) + "'; use auto, on or off");
}

/// A context may hold more devices than the one that the program was built for.
std::string binary_for(const cl::Program& program, const cl::Device& device) {
    const std::vector<cl::Device> devices = program.getInfo<CL_PROGRAM_DEVICES>();
    const auto binaries = program.getInfo<CL_PROGRAM_BINARIES>();
    for (std::size_t i = 0; i < devices.size() && i < binaries.size(); ++i) {
        if (devices[i]() == device()) return {binaries[i].begin(), binaries[i].end()};
    }
    return {};
}

}  // namespace

fs::path cache_folder() {
    if (const std::string_view folder = environment("CLBVH_CACHE_DIR"); !folder.empty()) return folder;
    return user_folder("XDG_CACHE_HOME", ".cache");
}

bool driver_caches_programs(const DeviceInfo& info) {
    return info.platform == kPoclPlatform || info.platform == "NVIDIA CUDA";
}

std::optional<ProgramStore> program_store_for(const DeviceInfo& info, ProgramCaching caching) {
    if (caching == ProgramCaching::automatic) caching = caching_variable();
    if (caching == ProgramCaching::automatic) {
        caching = driver_caches_programs(info) ? ProgramCaching::off : ProgramCaching::on;
    }
    const fs::path folder = caching == ProgramCaching::on ? cache_folder() : fs::path{};
    if (folder.empty()) return std::nullopt;
    return ProgramStore(folder);
}

ProgramCache::ProgramCache(const DeviceInfo& info, std::optional<ProgramStore> store) : store_(std::move(store)) {
    if (!store_) return;
    device_key_ =
        info.platform + '\n' + info.vendor + '\n' + info.name + '\n' + info.version + '\n' + info.driver_version + '\n';
    if (info.type == DeviceType::cpu) device_key_ += hexadecimal(fnv1a(processor_flags()));
    device_key_ += '\n';
}

std::string ProgramCache::key_of(const std::string& source, const std::string& options) const {
    return device_key_ + options + '\n' + std::to_string(source.size()) + ' ' + hexadecimal(fnv1a(source)) + '\n';
}

std::optional<cl::Program> ProgramCache::load(const cl::Context& context, const cl::Device& device,
                                              const std::string& source, const std::string& options) const {
    if (!store_) return std::nullopt;
    const std::optional<std::string> binary = store_->load(key_of(source, options));
    if (!binary) return std::nullopt;
    try {
        const cl::Program::Binaries binaries{std::vector<unsigned char>(binary->begin(), binary->end())};
        cl::Program program(context, {device}, binaries);
        program.build(device, options.c_str());
        return program;
    } catch (const cl::Error&) {
        return std::nullopt;
    }
}

void ProgramCache::store(const cl::Program& program, const cl::Device& device, const std::string& source,
                         const std::string& options) const {
    if (!store_) return;
    try {
        const std::string binary = binary_for(program, device);
        if (!binary.empty()) store_->store(key_of(source, options), binary);
    } catch (const cl::Error&) {
        return;  // a driver need not have binaries
    }
}

}  // namespace clbvh::device
