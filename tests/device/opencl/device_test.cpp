// Which device a selector picks, and what is said where none fits.
#include "clbvh/device/device.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <optional>

#include "clbvh/builder.hpp"
#include "clbvh/device/context.hpp"
#include "support/environment_variable.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

/// CLBVH_DEVICE set to something else, or unset, as long as this lives.
class DeviceVariable : public EnvironmentVariable {
public:
    explicit DeviceVariable(const char* value) : EnvironmentVariable("CLBVH_DEVICE", value) {}
};

std::string upper_case(std::string text) {
    std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return text;
}

/// The first device of this type.
std::optional<DeviceInfo> first_of(DeviceType type) {
    const std::vector<DeviceInfo> devices = list_devices();
    const auto found = std::ranges::find(devices, type, &DeviceInfo::type);
    return found == devices.end() ? std::nullopt : std::optional(*found);
}

/// Checks the error of a selector that fits nothing: it quotes the selector and lists every device.
void expect_none_fits(const std::string& source, const std::string& selector, const std::string& argument) {
    for (const DeviceInfo& info : list_devices()) {
        expect_error(ErrorCode::no_device,
                     {source + " '" + selector + "'", std::to_string(info.index) + " = " + info.name,
                      std::string(to_string(info.type))},
                     [&] { (void)pick_device(argument); });
    }
}

}  // namespace

TEST_CASE("devices: the list is numbered and describes usable devices") {
    const std::vector<DeviceInfo> devices = list_devices();
    REQUIRE_FALSE(devices.empty());
    for (std::size_t i = 0; i < devices.size(); ++i) {
        const DeviceInfo& info = devices[i];
        INFO(info.name);
        CHECK(info.index == i);
        CHECK_FALSE(info.name.empty());
        CHECK_FALSE(info.platform.empty());
        CHECK(info.version.starts_with("OpenCL "));
        CHECK(info.compute_units > 0);
        CHECK(info.max_work_group_size > 0);
        CHECK(info.local_memory_bytes > 0);
        CHECK(info.max_allocation_bytes <= info.global_memory_bytes);
        CHECK(info.max_allocation_bytes > 0);
        CHECK(info.id != nullptr);
    }
}

TEST_CASE("devices: a selector is an index, a type or a part of a name") {
    const DeviceVariable unset(nullptr);
    for (const DeviceInfo& info : list_devices()) {
        CHECK(pick_device(std::to_string(info.index)).id == info.id);
        CHECK(pick_device(info.name).name == info.name);
        CHECK(pick_device(upper_case(info.name.substr(1))).name == info.name);
    }
    for (const DeviceType type : {DeviceType::gpu, DeviceType::cpu, DeviceType::accelerator}) {
        const std::string name(to_string(type));
        if (const std::optional<DeviceInfo> first = first_of(type)) {
            CHECK(pick_device(name).index == first->index);
            CHECK(pick_device(upper_case(name)).index == first->index);
        } else {
            expect_none_fits("the device selector", name, name);
        }
    }
}

TEST_CASE("devices: without a selector the first GPU, else the first CPU") {
    const std::optional<DeviceInfo> gpu = first_of(DeviceType::gpu);
    const std::optional<DeviceInfo> cpu = first_of(DeviceType::cpu);
    const DeviceInfo expected = gpu ? *gpu : cpu ? *cpu : list_devices().front();
    for (const char* const variable : {static_cast<const char*>(nullptr), ""}) {
        const DeviceVariable value(variable);
        CHECK(pick_device().index == expected.index);
        CHECK(pick_device("").index == expected.index);
    }
}

TEST_CASE("devices: CLBVH_DEVICE stands in for no selector, and gives way to one") {
    const DeviceInfo last = list_devices().back();
    {
        const DeviceVariable index(std::to_string(last.index).c_str());
        CHECK(pick_device().id == last.id);
        CHECK(Context::open().device().id == last.id);
    }
    const DeviceVariable nothing("no such device");
    CHECK(pick_device(std::to_string(last.index)).id == last.id);
    expect_none_fits("CLBVH_DEVICE", "no such device", "");
    expect_error(ErrorCode::no_device, {"CLBVH_DEVICE"}, [] { (void)Context::open(); });
}

TEST_CASE("devices: a selector that fits none is an error that lists what there is") {
    const DeviceVariable unset(nullptr);
    expect_none_fits("the device selector", "no such device", "no such device");
    expect_none_fits("the device selector", "4096", "4096");
    expect_none_fits("the device selector", "-1", "-1");
    expect_none_fits("the device selector", "99999999999999999999999", "99999999999999999999999");
}

// Run with an environment in which the loader finds no driver; see CMakeLists.txt.
TEST_CASE("no device: the error says what to install", "[.no_device]") {
    CHECK(list_devices().empty());
    for (const char* const selector : {"", "0", "gpu", "pocl"}) {
        expect_error(ErrorCode::no_device, {"no OpenCL device", "install", "pocl-opencl-icd", "clinfo"},
                     [&] { (void)pick_device(selector); });
    }
    expect_error(ErrorCode::no_device, {"pocl-opencl-icd"}, [] { (void)Context::open(); });
    expect_error(ErrorCode::no_device, {"pocl-opencl-icd"}, [] { (void)Builder("plocpp"); });
    expect_error(ErrorCode::invalid_input, {"known are"}, [] { (void)Builder("no such builder"); });
}
