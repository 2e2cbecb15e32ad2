#pragma once

#include <span>
#include <vector>

#include "clbvh/device/device_tracer.hpp"
#include "device/opencl/opencl.hpp"

namespace clbvh::test {

/// Memory for tracing rays on the shared context, with guard bytes around what the tracer writes.
class DeviceRayMemory {
public:
    DeviceRayMemory(const DeviceTracer& tracer, const DeviceBvh& bvh, std::span<const Ray> rays,
                    LayoutKind kind = LayoutKind::wide8);

    /// Where the rays, their hits and counts are.
    [[nodiscard]] DeviceRays rays() const;
    /// Where a layout of this kind may be made.
    [[nodiscard]] DeviceSpan layout() const { return layout_.span; }

    [[nodiscard]] std::vector<Hit> hits() const;
    [[nodiscard]] std::vector<std::uint8_t> bytes() const;
    [[nodiscard]] std::vector<RayCounts> counts() const;
    [[nodiscard]] bool guards_are_whole() const;

private:
    struct Guarded {
        cl::Buffer buffer;
        std::uint64_t bytes = 0;
        DeviceSpan span;
    };
    static Guarded make_guarded(std::uint64_t bytes);

    std::uint32_t count_;
    cl::Buffer rays_;
    Guarded results_, counts_, scratch_, layout_;
};

}  // namespace clbvh::test
