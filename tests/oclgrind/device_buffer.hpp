#pragma once

#include <CL/cl.h>

#include <clbvh/device/context.hpp>
#include <clbvh/device/memory.hpp>
#include <cstddef>
#include <span>
#include <vector>

/// A buffer of the device with these values, or with room for so many bytes.
class DeviceBuffer {
public:
    DeviceBuffer(const clbvh::Context& context, std::size_t bytes)
        : buffer_(clCreateBuffer(context.opencl_context(), CL_MEM_READ_WRITE, bytes, nullptr, nullptr)) {}
    template <typename T>
    DeviceBuffer(const clbvh::Context& context, const std::vector<T>& values)
        : DeviceBuffer(context, values.size() * sizeof(T)) {
        clEnqueueWriteBuffer(context.opencl_queue(), buffer_, CL_TRUE, 0, values.size() * sizeof(T), values.data(), 0,
                             nullptr, nullptr);
    }
    DeviceBuffer(const DeviceBuffer&) = delete;
    DeviceBuffer& operator=(const DeviceBuffer&) = delete;
    ~DeviceBuffer() { clReleaseMemObject(buffer_); }

    template <typename T>
    void read(const clbvh::Context& context, std::span<T> values) const {
        clEnqueueReadBuffer(context.opencl_queue(), buffer_, CL_TRUE, 0, values.size_bytes(), values.data(), 0, nullptr,
                            nullptr);
    }
    [[nodiscard]] clbvh::DeviceSpan span() const { return {buffer_, 0}; }

private:
    cl_mem buffer_;
};
