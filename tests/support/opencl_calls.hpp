#pragma once

#include <cstddef>

namespace clbvh::test {

/// Calls into OpenCL so far, by this program and all that it links: it puts itself between them and the driver.
struct OpenClCalls {
    std::size_t buffers = 0;      ///< Memory objects and shared virtual memory that were allocated.
    std::size_t sub_buffers = 0;  ///< Views of buffers; no memory.
    std::size_t programs = 0;     ///< Programs that were created or built.
    std::size_t launches = 0;     ///< Kernels that were enqueued.
    std::size_t waits = 0;        ///< Calls that wait for the device: clFinish, clWaitForEvents, blocking copies.
    std::size_t copied = 0;       ///< Bytes that buffers were filled with from arrays of the host.

    friend bool operator==(const OpenClCalls&, const OpenClCalls&) = default;
};

[[nodiscard]] OpenClCalls opencl_calls();

/// Lets the next `allowed` buffers and views of buffers be made, and no more until allow_buffers(), as where a device's
/// memory runs out.
void allow_buffers(long allowed);
/// Lets all be made again.
void allow_buffers();

/// The calls that `body` made.
template <typename Body>
[[nodiscard]] OpenClCalls opencl_calls_of(Body&& body) {
    const OpenClCalls before = opencl_calls();
    body();
    const OpenClCalls after = opencl_calls();
    return {after.buffers - before.buffers,   after.sub_buffers - before.sub_buffers,
            after.programs - before.programs, after.launches - before.launches,
            after.waits - before.waits,       after.copied - before.copied};
}

}  // namespace clbvh::test
