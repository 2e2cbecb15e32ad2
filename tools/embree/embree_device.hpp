#pragma once

#include <embree3/rtcore.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <string_view>
#include <type_traits>

namespace clbvh::tool {

/// Calls Embree's function that releases a handle.
template <auto Release>
struct EmbreeReleaser {
    template <typename Handle>
    void operator()(Handle* handle) const {
        Release(handle);
    }
};

template <typename Handle, auto Release>
using EmbreeHandle = std::unique_ptr<std::remove_pointer_t<Handle>, EmbreeReleaser<Release>>;

/// Bytes that Embree has allocated, as its memory monitor reports it.
class EmbreeMemory {
public:
    /// This object outlives the device, and stays where it is.
    void watch(RTCDevice device) { rtcSetDeviceMemoryMonitorFunction(device, add, this); }
    [[nodiscard]] std::uint64_t peak() const { return static_cast<std::uint64_t>(peak_.load()); }

private:
    static bool add(void* self, ssize_t bytes, bool after);

    std::atomic<std::int64_t> now_ = 0;
    std::atomic<std::int64_t> peak_ = 0;
};

/// Embree on huge pages, which the library's own builders ask for too. Its work is done by the threads of the
/// task_arena that calls it: a number of threads given to Embree would hold for the whole process.
class EmbreeDevice {
public:
    /// `user` is named in errors, and lives as long as this object.
    explicit EmbreeDevice(std::string_view user);

    [[nodiscard]] RTCDevice get() const { return device_.get(); }
    [[nodiscard]] std::uint64_t peak_bytes() const { return memory_.peak(); }
    /// Throws the clbvh::Error that stands for Embree's last error where `success` is false.
    void require(bool success) const;
    /// Throws the same where a call that returns nothing has left an error.
    void require_no_error() const;

private:
    [[noreturn]] void fail(RTCError code) const;

    std::string_view user_;
    EmbreeMemory memory_;
    EmbreeHandle<RTCDevice, rtcReleaseDevice> device_;
};

}  // namespace clbvh::tool
