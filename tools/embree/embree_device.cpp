#include "embree/embree_device.hpp"

#include <clbvh/core/error.hpp>
#include <string>

#include "cli/interrupt.hpp"
#include "embree/embree_error.hpp"

namespace clbvh::tool {

bool EmbreeMemory::add(void* self, ssize_t bytes, bool) {
    auto* memory = static_cast<EmbreeMemory*>(self);
    const std::int64_t now = memory->now_ += bytes;
    std::int64_t peak = memory->peak_;
    while (now > peak && !memory->peak_.compare_exchange_weak(peak, now)) {
    }
    return true;
}

EmbreeDevice::EmbreeDevice(std::string_view user) : user_(user), device_(rtcNewDevice("hugepages=1")) {
    require(device_ != nullptr);
    memory_.watch(device_.get());
}

void EmbreeDevice::require(bool success) const {
    if (!success) fail(rtcGetDeviceError(device_.get()));
}

void EmbreeDevice::require_no_error() const {
    const RTCError code = rtcGetDeviceError(device_.get());
    if (code != RTC_ERROR_NONE) fail(code);
}

void EmbreeDevice::fail(RTCError code) const {
    if (code == RTC_ERROR_CANCELLED) throw_if_interrupted();
    throw Error(code == RTC_ERROR_OUT_OF_MEMORY ? ErrorCode::out_of_memory : ErrorCode::unsupported,
                std::string(user_) + " failed with " + std::string(embree_error_name(code)));
}

}  // namespace clbvh::tool
