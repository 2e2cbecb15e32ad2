#include "device/opencl/language.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace clbvh::device {
namespace {

// The headers in use may be older than these (OpenCL 3.0; cl_nv_device_attribute_query).
constexpr cl_device_info kAllVersions = 0x1066;
constexpr cl_device_info kFeatures = 0x106F;
constexpr cl_device_info kNvidiaMajor = 0x4000;
constexpr cl_device_info kNvidiaMinor = 0x4001;
constexpr std::uint32_t kVersion3 = 3u << 22;  // CL_MAKE_VERSION(3, 0, 0)
constexpr std::uint32_t kMinorMask = ~0xFFFu;  // all but the patch

/// cl_name_version
struct NameVersion {
    std::uint32_t version;
    std::array<char, 64> name;
};

std::vector<NameVersion> name_versions(const cl::Device& device, cl_device_info what) {
    std::size_t bytes = 0;
    if (clGetDeviceInfo(device(), what, 0, nullptr, &bytes) != CL_SUCCESS) return {};
    std::vector<NameVersion> list(bytes / sizeof(NameVersion));
    if (clGetDeviceInfo(device(), what, list.size() * sizeof(NameVersion), list.data(), nullptr) != CL_SUCCESS)
        return {};
    return list;
}

std::uint32_t number(const cl::Device& device, cl_device_info what) {
    cl_uint value = 0;
    return clGetDeviceInfo(device(), what, sizeof(value), &value, nullptr) == CL_SUCCESS ? value : 0;
}

bool has_feature(const LanguageFacts& facts, std::string_view name) {
    return std::ranges::find(facts.features, name) != facts.features.end();
}

std::string standard_of(const LanguageFacts& facts) {
    const bool has_fence =
        has_feature(facts, "__opencl_c_atomic_order_acq_rel") && has_feature(facts, "__opencl_c_atomic_scope_device");
    if (facts.has_3_0 && has_fence) return "CL3.0";
    return facts.version.starts_with("OpenCL C 2.") ? "CL2.0" : "CL1.2";
}

}  // namespace

LanguageFacts language_facts(const cl::Device& device, DeviceType type) {
    LanguageFacts facts;
    facts.type = type;
    facts.version = device.getInfo<CL_DEVICE_OPENCL_C_VERSION>();
    if (device.getInfo<CL_DEVICE_VERSION>().starts_with("OpenCL 3.")) {
        facts.has_3_0 = std::ranges::any_of(name_versions(device, kAllVersions), [](const NameVersion& version) {
            return (version.version & kMinorMask) == kVersion3;
        });
        for (const NameVersion& feature : name_versions(device, kFeatures)) {
            const auto end = std::ranges::find(feature.name, '\0');
            facts.features.emplace_back(feature.name.begin(), end);
        }
    }
    if (device.getInfo<CL_DEVICE_EXTENSIONS>().find("cl_nv_device_attribute_query") != std::string::npos) {
        facts.nvidia_major = number(device, kNvidiaMajor);
        facts.nvidia_minor = number(device, kNvidiaMinor);
    }
    facts.rounds_divisions = (device.getInfo<CL_DEVICE_SINGLE_FP_CONFIG>() & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
    return facts;
}

std::string language_options(const LanguageFacts& facts) {
    if (facts.type == DeviceType::cpu) return "-cl-std=CL1.2";
    std::string options = "-cl-std=" + standard_of(facts);
    if (facts.nvidia_major != 0) {
        options += " -D COMPUTE_CAPABILITY=" + std::to_string(10 * facts.nvidia_major + facts.nvidia_minor);
    }
    return options + (facts.rounds_divisions ? " -cl-fp32-correctly-rounded-divide-sqrt" : "");
}

}  // namespace clbvh::device
