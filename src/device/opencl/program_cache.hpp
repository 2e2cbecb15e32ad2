#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "clbvh/device/context.hpp"
#include "device/opencl/opencl.hpp"
#include "device/opencl/program_store.hpp"

namespace clbvh::device {

/// The name of PoCL's platform.
inline constexpr std::string_view kPoclPlatform = "Portable Computing Language";

/// The folder of the library's caches: CLBVH_CACHE_DIR, else clbvh in XDG_CACHE_HOME, else in ~/.cache. Empty where
/// none of these variables and no HOME is set.
[[nodiscard]] std::filesystem::path cache_folder();

/// True for drivers that keep programs on disk by themselves.
[[nodiscard]] bool driver_caches_programs(const DeviceInfo& info);

/// Where programs of this device are kept, if at all. `caching` decides; where it is automatic the variable CLBVH_CACHE
/// ("on", "off", "auto") does, and where that leaves it open: driver_caches_programs.
/// Throws Error(invalid_input) for another value of the variable.
[[nodiscard]] std::optional<ProgramStore> program_store_for(const DeviceInfo& info, ProgramCaching caching);

/// Programs built for one device, kept between processes. Nothing fails: a program that cannot be loaded is built from
/// source.
class ProgramCache {
public:
    ProgramCache() = default;  ///< Keeps nothing.
    ProgramCache(const DeviceInfo& info, std::optional<ProgramStore> store);

    /// The program that was stored for this source and these options, built; nothing where there is none, or the driver
    /// does not take it.
    [[nodiscard]] std::optional<cl::Program> load(const cl::Context& context, const cl::Device& device,
                                                  const std::string& source, const std::string& options) const;

    /// Keeps a program that was built for `device`.
    void store(const cl::Program& program, const cl::Device& device, const std::string& source,
               const std::string& options) const;

    /// All that a binary depends on, in lines.
    [[nodiscard]] std::string key_of(const std::string& source, const std::string& options) const;

private:
    std::string device_key_;
    std::optional<ProgramStore> store_;
};

}  // namespace clbvh::device
