#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clbvh/device/device.hpp"
#include "device/opencl/opencl.hpp"

namespace clbvh::device {

/// What a device says of the OpenCL C that it compiles.
struct LanguageFacts {
    DeviceType type = DeviceType::other;
    std::string version;                ///< CL_DEVICE_OPENCL_C_VERSION: "OpenCL C 1.2 ..."
    bool has_3_0 = false;               ///< 3.0 is among CL_DEVICE_OPENCL_C_ALL_VERSIONS.
    std::vector<std::string> features;  ///< CL_DEVICE_OPENCL_C_FEATURES
    std::uint32_t nvidia_major = 0;     ///< NVIDIA's compute capability; 0 elsewhere
    std::uint32_t nvidia_minor = 0;
    bool rounds_divisions = false;  ///< CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT
};

/// Asks the device. What it does not know is left as it is.
[[nodiscard]] LanguageFacts language_facts(const cl::Device& device, DeviceType type);

/// The options that choose the language: the least that has a fence of the whole device (between_groups.clh). On CPU
/// devices, whose cores see one memory, and where no language has such a fence, OpenCL C 1.2. Others than CPUs, which
/// do so anyway, round divisions correctly where they can: Morton codes are then the host's.
[[nodiscard]] std::string language_options(const LanguageFacts& facts);

}  // namespace clbvh::device
