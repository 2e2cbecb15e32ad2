#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "clbvh/export.h"

namespace clbvh {

/// The kinds of OpenCL device that defaults depend on.
enum class DeviceType : std::uint8_t { gpu, cpu, accelerator, other };

/// "gpu", "cpu", "accelerator" or "other".
[[nodiscard]] constexpr std::string_view to_string(DeviceType type) noexcept {
    switch (type) {
        case DeviceType::gpu: return "gpu";
        case DeviceType::cpu: return "cpu";
        case DeviceType::accelerator: return "accelerator";
        case DeviceType::other: break;
    }
    return "other";
}

/// One OpenCL device as the system lists it.
struct DeviceInfo {
    std::size_t index = 0;  ///< Position in list_devices(), over all platforms.
    std::string name;
    std::string vendor;
    std::string platform;
    std::string version;  ///< OpenCL version string of the device.
    std::string driver_version;
    DeviceType type = DeviceType::other;
    std::uint32_t compute_units = 0;
    std::size_t max_work_group_size = 0;
    std::uint64_t local_memory_bytes = 0;
    std::uint64_t global_memory_bytes = 0;
    std::uint64_t max_allocation_bytes = 0;
    bool int64_atomics = false;  ///< cl_khr_int64_extended_atomics, local and global.
    void* id = nullptr;          ///< The cl_device_id.
};

/// A driver that does not say what devices it has, or nothing of one of them.
struct PlatformFault {
    std::string platform;  ///< Its name; its number in the loader's order where it has none.
    std::string reason;    ///< What failed, and the error of OpenCL.
};

/// All devices of all platforms, in the loader's order. Empty where there is none, or the library was built without
/// OpenCL. A driver that fails is passed over, and told of in `faults` where that is given, so that it hides no other.
/// Throws Error(device_failure) where OpenCL's loader itself fails.
[[nodiscard]] CLBVH_API std::vector<DeviceInfo> list_devices(std::vector<PlatformFault>* faults = nullptr);

/// Picks a device. `selector` is an index into list_devices(), a type ("gpu", "cpu", "accelerator"), or a part of a
/// name (case ignored). Where it is empty the environment variable CLBVH_DEVICE stands in, and where that is empty too:
/// the first GPU, else the first CPU, else the first device. Throws Error(no_device): none at all (the message says
/// what to install, and which drivers failed) or none that fits (it lists what there is); Error(unsupported) where the
/// library was built without OpenCL.
[[nodiscard]] CLBVH_API DeviceInfo pick_device(std::string_view selector = {});

}  // namespace clbvh
