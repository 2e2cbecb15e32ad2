// Which OpenCL C a device is given: the least that has a fence of the whole device.
#include "device/opencl/language.hpp"

#include <catch2/catch.hpp>

#include "clbvh/device/context.hpp"
#include "support/builders.hpp"

using namespace clbvh;
using namespace clbvh::test;
using device::language_options;
using device::LanguageFacts;

namespace {

constexpr const char* kOrder = "__opencl_c_atomic_order_acq_rel";
constexpr const char* kScope = "__opencl_c_atomic_scope_device";

LanguageFacts gpu(const char* version) {
    LanguageFacts facts;
    facts.type = DeviceType::gpu;
    facts.version = version;
    return facts;
}

}  // namespace

TEST_CASE("language: 3.0 where both parts of it that the fence needs are there") {
    LanguageFacts facts = gpu("OpenCL C 1.2 ");  // as Intel's driver says
    facts.has_3_0 = true;
    CHECK(language_options(facts) == "-cl-std=CL1.2");
    facts.features = {kOrder};
    CHECK(language_options(facts) == "-cl-std=CL1.2");
    facts.features = {"__opencl_c_int64", kOrder, kScope};
    CHECK(language_options(facts) == "-cl-std=CL3.0");
    facts.has_3_0 = false;
    CHECK(language_options(facts) == "-cl-std=CL1.2");
}

TEST_CASE("language: 2.0, which has the fence, where the device compiles nothing newer with it") {
    CHECK(language_options(gpu("OpenCL C 2.0 ")) == "-cl-std=CL2.0");  // as AMD's driver says
    CHECK(language_options(gpu("OpenCL C 1.2 ")) == "-cl-std=CL1.2");
    LanguageFacts facts = gpu("OpenCL C 2.0 ");
    facts.has_3_0 = true;
    CHECK(language_options(facts) == "-cl-std=CL2.0");
}

TEST_CASE("language: NVIDIA's compute capability chooses between its fences") {
    LanguageFacts facts = gpu("OpenCL C 1.2 ");
    facts.nvidia_major = 9;
    CHECK(language_options(facts) == "-cl-std=CL1.2 -D COMPUTE_CAPABILITY=90");
    facts.nvidia_major = 7;
    facts.nvidia_minor = 5;
    CHECK(language_options(facts) == "-cl-std=CL1.2 -D COMPUTE_CAPABILITY=75");
}

TEST_CASE("language: divisions are rounded correctly where the device can") {
    LanguageFacts facts = gpu("OpenCL C 2.0 ");
    facts.rounds_divisions = true;
    CHECK(language_options(facts) == "-cl-std=CL2.0 -cl-fp32-correctly-rounded-divide-sqrt");
}

TEST_CASE("language: processors, whose cores see one memory, are given 1.2") {
    LanguageFacts facts = gpu("OpenCL C 2.0 ");
    facts.has_3_0 = true;
    facts.features = {kOrder, kScope};
    facts.type = DeviceType::cpu;
    CHECK(language_options(facts) == "-cl-std=CL1.2");
}

TEST_CASE("language: a device is asked what it compiles") {
    const cl::Device device(static_cast<cl_device_id>(shared_context().device().id), true);
    const LanguageFacts facts = device::language_facts(device, DeviceType::gpu);
    CHECK(facts.type == DeviceType::gpu);
    CHECK_THAT(facts.version, Catch::StartsWith("OpenCL C "));
    const bool is_3 = shared_context().device().version.find("OpenCL 3.") == 0;
    CHECK(facts.features.empty() == !is_3);
    if (shared_context().device().platform == "Portable Computing Language") {
        CHECK_THAT(language_options(facts), Catch::StartsWith(is_3 ? "-cl-std=CL3.0" : "-cl-std=CL1.2"));
    }
}
