#include "clbvh/device/device.hpp"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdlib>

#include "clbvh/core/error.hpp"
#include "device/opencl/device_info.hpp"
#include "device/opencl/opencl.hpp"

namespace clbvh {
namespace {

using device::with_opencl_errors;

// The ICD loader's answer where no driver is installed (cl_khr_icd).
constexpr cl_int kPlatformNotFound = -1001;

DeviceType type_of(cl_device_type bits) {
    if ((bits & CL_DEVICE_TYPE_GPU) != 0) return DeviceType::gpu;
    if ((bits & CL_DEVICE_TYPE_CPU) != 0) return DeviceType::cpu;
    if ((bits & CL_DEVICE_TYPE_ACCELERATOR) != 0) return DeviceType::accelerator;
    return DeviceType::other;
}

// Some drivers count the terminating zero or pad with blanks.
std::string trimmed(std::string text) {
    const auto blank = [](char c) { return c == '\0' || std::isspace(static_cast<unsigned char>(c)) != 0; };
    while (!text.empty() && blank(text.back())) {
        text.pop_back();
    }
    const auto begin = std::find_if_not(text.begin(), text.end(), blank);
    return {begin, text.end()};
}

std::string lower_case(std::string_view text) {
    std::string lower(text);
    std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return lower;
}

std::vector<cl::Platform> list_platforms() {
    std::vector<cl::Platform> platforms;
    try {
        cl::Platform::get(&platforms);
    } catch (const cl::Error& error) {
        if (error.err() != kPlatformNotFound) {
            device::throw_opencl_error(error, "listing the platforms");
        }
    }
    return platforms;
}

/// The platform's name; its number where it does not tell.
std::string name_of(const cl::Platform& platform, std::size_t number) {
    try {
        return trimmed(platform.getInfo<CL_PLATFORM_NAME>());
    } catch (const cl::Error&) {
        return "platform " + std::to_string(number);
    }
}

std::vector<cl::Device> devices_of(const cl::Platform& platform) {
    std::vector<cl::Device> devices;
    try {
        platform.getDevices(CL_DEVICE_TYPE_ALL, &devices);
    } catch (const cl::Error& error) {
        if (error.err() != CL_DEVICE_NOT_FOUND) {
            device::throw_opencl_error(error, "listing the devices");
        }
    }
    return devices;
}

std::string describe(const std::vector<DeviceInfo>& devices) {
    std::string text;
    for (const DeviceInfo& info : devices) {
        text += (text.empty() ? "" : ", ") + std::to_string(info.index) + " = " + info.name + " (" +
                std::string(to_string(info.type)) + ")";
    }
    return text;
}

bool matches(const DeviceInfo& info, std::string_view selector) {
    std::size_t index = 0;
    const char* const end = selector.data() + selector.size();
    const auto [parsed_to, error] = std::from_chars(selector.data(), end, index);
    if (error == std::errc() && parsed_to == end) {
        return info.index == index;
    }
    const std::string wanted = lower_case(selector);
    if (wanted == "gpu" || wanted == "cpu" || wanted == "accelerator") {
        return to_string(info.type) == wanted;
    }
    return lower_case(info.name).find(wanted) != std::string::npos;
}

/// What to do where there is no device.
std::string advice(const std::vector<PlatformFault>& faults) {
    std::string text;
    for (const PlatformFault& fault : faults)
        text += fault.platform + " fails: " + fault.reason + "; ";
    const char* const home = std::getenv("HOME");
    // Among others PoCL keeps what it compiles there, and has no device where it cannot.
    if (home == nullptr || access(home, W_OK) != 0) {
        text += std::string("HOME, ") + (home == nullptr ? "which is not set" : home) +
                ", cannot be written, without which some drivers offer nothing; ";
    }
    return text +
           "install a driver: pocl-opencl-icd for the CPU (apt-get install pocl-opencl-icd), or that of your GPU's "
           "vendor; clinfo lists what the system sees";
}

DeviceInfo default_device(const std::vector<DeviceInfo>& devices) {
    for (const DeviceType type : {DeviceType::gpu, DeviceType::cpu}) {
        const auto found = std::ranges::find(devices, type, &DeviceInfo::type);
        if (found != devices.end()) {
            return *found;
        }
    }
    return devices.front();
}

}  // namespace

namespace device {

DeviceInfo describe_device(const cl::Device& device) {
    return with_opencl_errors("asking for a device's properties", [&] {
        DeviceInfo info;
        info.name = trimmed(device.getInfo<CL_DEVICE_NAME>());
        info.vendor = trimmed(device.getInfo<CL_DEVICE_VENDOR>());
        info.platform = trimmed(cl::Platform(device.getInfo<CL_DEVICE_PLATFORM>()).getInfo<CL_PLATFORM_NAME>());
        info.version = trimmed(device.getInfo<CL_DEVICE_VERSION>());
        info.driver_version = trimmed(device.getInfo<CL_DRIVER_VERSION>());
        info.type = type_of(device.getInfo<CL_DEVICE_TYPE>());
        info.compute_units = device.getInfo<CL_DEVICE_MAX_COMPUTE_UNITS>();
        info.max_work_group_size = device.getInfo<CL_DEVICE_MAX_WORK_GROUP_SIZE>();
        info.local_memory_bytes = device.getInfo<CL_DEVICE_LOCAL_MEM_SIZE>();
        info.global_memory_bytes = device.getInfo<CL_DEVICE_GLOBAL_MEM_SIZE>();
        info.max_allocation_bytes = device.getInfo<CL_DEVICE_MAX_MEM_ALLOC_SIZE>();
        const std::string extensions = device.getInfo<CL_DEVICE_EXTENSIONS>();
        info.int64_atomics = extensions.find("cl_khr_int64_extended_atomics") != std::string::npos;
        info.id = device();
        return info;
    });
}

}  // namespace device

std::vector<DeviceInfo> list_devices(std::vector<PlatformFault>* faults) {
    std::vector<DeviceInfo> devices;
    const std::vector<cl::Platform> platforms = list_platforms();
    for (std::size_t number = 0; number < platforms.size(); ++number) {
        const auto pass_over = [&](const Error& error) {
            if (faults != nullptr) faults->push_back({name_of(platforms[number], number), error.what()});
        };
        std::vector<cl::Device> found;
        try {
            found = devices_of(platforms[number]);
        } catch (const Error& error) {
            pass_over(error);
        }
        for (const cl::Device& device : found) {
            try {
                DeviceInfo info = device::describe_device(device);
                info.index = devices.size();
                devices.push_back(std::move(info));
            } catch (const Error& error) {
                pass_over(error);
            }
        }
    }
    return devices;
}

DeviceInfo pick_device(std::string_view selector) {
    std::vector<PlatformFault> faults;
    const std::vector<DeviceInfo> devices = list_devices(&faults);
    if (devices.empty()) throw Error(ErrorCode::no_device, "no OpenCL device found; " + advice(faults));
    std::string_view source = "the device selector";
    if (const char* const variable = std::getenv("CLBVH_DEVICE"); selector.empty() && variable != nullptr) {
        selector = variable;
        source = "CLBVH_DEVICE";
    }
    if (selector.empty()) {
        return default_device(devices);
    }
    const auto found = std::ranges::find_if(devices, [&](const DeviceInfo& info) { return matches(info, selector); });
    if (found == devices.end()) {
        throw Error(ErrorCode::no_device, "no OpenCL device fits " + std::string(source) + " '" +
                                              std::string(selector) + "'; there is: " + describe(devices));
    }
    return *found;
}

}  // namespace clbvh
